"""The life of a track, the content of its row, and its separation from other tracks."""

from dataclasses import replace

import numpy as np
import pytest
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import TRACK
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig


@pytest.mark.parametrize('variance', [0.01, 4.0])
def test_detections_without_boxes_are_points(variance):
    found = []
    for boxes in (True, False):
        tracker = Tracker(TrackerConfig(use_boxes=boxes))
        for k in range(5):
            rows = tracker.update(points([(50 + k, 9)], k * FRAME, variance)).rows
        found.append(rows.tobytes())
    assert found[0] == found[1]


def test_one_message_in_is_one_message_out_with_its_header():
    tracker = Tracker()
    for k, z in enumerate([[], [(5, 5)], [], []]):
        tracks = tracker.update(points(z, k * FRAME))
        assert (tracks.stamp, tracks.frame_id, tracks.restarted) == (k * FRAME, 'camera', '')
        assert tracks.rows.dtype == TRACK


def test_a_track_is_tentative_then_confirmed_then_coasting_then_gone():
    tracker = Tracker(TrackerConfig(max_time_since_update=3.5 / 24))
    seen = []
    for k in range(9):
        rows = tracker.update(points([(10 + 2 * k, 7)] if k < 4 else [], k * FRAME)).rows
        seen.append(rows['state'].tolist())
    assert seen == [[TENTATIVE]] * 2 + [[CONFIRMED]] * 2 + [[COASTING]] * 3 + [[]] * 2


@pytest.mark.parametrize('boxes', [True, False])
def test_the_box_lies_around_the_position_as_it_lay_around_the_centroid(boxes):
    tracker = Tracker(TrackerConfig(use_boxes=boxes))
    for k in range(9):
        detections = points([(40.0 + 2 * k, 30)] if k < 8 else [], k * FRAME, 0.1)
        for name, value in (('box_u', 30 + 2 * k), ('box_v', 27), ('box_w', 40), ('box_h', 25)):
            detections.rows[name] = value
        row = tracker.update(detections).rows[0]
        assert row['box_u'] - row['u'] == pytest.approx(-10)
        assert row['box_v'] - row['v'] == pytest.approx(-3)
    assert row['state'] == COASTING
    assert row['box_u'] == pytest.approx(46, abs=1)


def test_what_a_row_says():
    tracker = Tracker()
    for k in range(6):
        detections = points([(10.0 + 2 * k, 7)] if k != 4 else [], k * FRAME, 0.1, color=3)
        detections.rows['area'], detections.rows['box_w'], detections.rows['box_h'] = 50, 8, 9
        row = tracker.update(detections).rows[0]
        if k == 4:
            assert row['time_since_update'] == pytest.approx(1 / 24)
            assert row['u'] == pytest.approx(18, abs=0.5)
    assert (row['track_id'], row['color'], row['hits'], row['area']) == (1, 3, 5, 50)
    assert (row['box_w'], row['box_h'], row['time_since_update']) == (8, 9, 0)
    assert row['age'] == pytest.approx(5 / 24)
    assert row['du'] == pytest.approx(48, abs=5)
    assert 0.9 < row['score'] <= 1


def test_a_false_detection_is_never_confirmed():
    tracker = Tracker()
    for k in range(8):
        rows = tracker.update(points([(10, 10)] if k == 2 else [], k * FRAME)).rows
        assert not rows['state'].any()
        assert len(rows) == 1 or k != 2
    assert len(rows) == 0


def test_reset_forgets_the_tracks_but_not_the_ids():
    tracker = Tracker()
    tracker.update(points([(1, 1)], NANOSECONDS))
    tracker.reset()
    assert tracker.update(points([(1, 1)], 0)).rows['track_id'].tolist() == [2]


def test_configure_keeps_the_tracks():
    tracker = Tracker()
    tracker.update(points([(1, 1)], 0))
    tracker.configure(replace(tracker.config, process_noise=5.0))
    assert tracker.update(points([(1, 1)], FRAME)).rows['hits'].tolist() == [2]


@pytest.mark.parametrize(('gating', 'ids'), [(True, [1, 2]), (False, [1])])
def test_another_color_is_another_object_if_color_gates(gating, ids):
    tracker = Tracker(TrackerConfig(color_gating=gating))
    tracker.update(points([(1, 1)], 0, color=0))
    rows = tracker.update(points([(1, 1)], FRAME, color=1)).rows
    assert rows['track_id'].tolist() == ids


@pytest.mark.parametrize(
    ('typed', 'told', 'coasting'),
    [
        ((0, 0), (0, 0), 36),
        ((100, 50), (0, 0), 1),
        ((0, 0), (100, 50), 1),
        ((100, 50), (900, 900), 1),
        ((900, 900), (100, 50), 36),
    ],
)
def test_a_track_that_has_left_the_picture_is_not_coasted_back_in(typed, told, coasting):
    """It moves right by 4 px a frame and is seen until u = 96. A typed size has priority."""
    tracker = Tracker(TrackerConfig(image_size=typed, min_score=0.0))
    for k in range(15, 25):
        tracker.update(replace(points([(4 * k, 20)], k * FRAME), image_size=told))
    lives = [len(tracker.update(points([], k * FRAME)).rows) for k in range(25, 65)]
    assert sum(lives) == pytest.approx(coasting, abs=1)


def test_a_track_that_nobody_knows_the_place_of_is_deleted():
    tracker = Tracker(TrackerConfig(max_position_sigma=40.0))
    for k in range(5):
        tracker.update(points([(9, 9)], k * FRAME))
    alive = 0
    while len(tracker.update(points([], (5 + alive) * FRAME)).rows):
        alive += 1
    assert 1 <= alive < 20


def test_where_color_does_not_gate_it_decides_between_two_as_near():
    """They rest side by side, and are seen slightly past each other once."""
    found = []
    for gating in (True, False):
        tracker = Tracker(TrackerConfig(color_gating=gating))
        for k, (one, other) in enumerate([(100, 104)] * 5 + [(102.2, 101.8)]):
            detections = points([(one, 50), (other, 50)], k * FRAME, 25.0)
            detections.rows['color'] = [0, 1]
            rows = tracker.update(detections).rows
        found.append(rows[['u', 'v', 'color']].tolist())
    assert found[0] == found[1]


@pytest.mark.slow
def test_the_same_messages_give_the_same_tracks_to_the_bit():
    rng = np.random.default_rng(3)
    frames = [points(rng.uniform(0, 300, (9, 2)), k * FRAME, 0.5) for k in range(30)]
    one, two = Tracker(), Tracker()
    for detections in frames:
        rows = one.update(detections).rows
        assert rows.tobytes() == two.update(detections).rows.tobytes()
        assert len(rows) >= 9


@pytest.mark.parametrize(
    ('name', 'value'),
    [
        ('process_noise', -1.0),
        ('measurement_noise', 0.0),
        ('max_dt', float('nan')),
        ('detection_probability', 1.0),
        ('confirm_window', 2),
        ('image_size', (640,)),
        ('acceleration', (0.0, float('inf'))),
        ('motion_model', 'teleport'),
        ('associator', ''),
    ],
)
def test_a_bad_value_is_refused_with_its_name_and_range(name, value):
    with pytest.raises(ValueError, match=f'^{name}: expected .*, got '):
        TrackerConfig(**{name: value})
