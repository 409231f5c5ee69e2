"""Which messages and detections a tracker accepts: late, repeated, broken, too many."""

from dataclasses import replace
import time

import numpy as np
import pytest
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig


@pytest.mark.parametrize(
    ('step', 'why'), [(-1, 'went back by 1.0'), (5, 'jumped ahead by 5.0'), (0.25, ''), (0, '')]
)
def test_stamps_that_are_out_of_order_start_afresh_and_say_why(step, why):
    tracker = Tracker()
    tracker.update(points([(1, 1)], 10 * NANOSECONDS))
    tracks = tracker.update(points([(9000, 90)], round((10 + step) * NANOSECONDS)))
    assert why in tracks.restarted
    assert bool(why) == bool(tracks.restarted)
    assert tracks.rows['track_id'].tolist() == ([2] if why else [1, 2])
    assert tracker.update(points([], tracks.stamp + FRAME)).restarted == ''


def test_detections_of_one_moment_may_come_in_several_messages():
    """Each part adds what the others lack; a track not in all of them is not missed."""
    whole, parts = Tracker(), Tracker()
    for k in range(12):
        z = np.array([(10.0 + k, 10), (200 - 2 * k, 50), (90, 90 + k)])
        rows = whole.update(points(z, k * FRAME)).rows
        for part in (z[:1], z[1:], z[:0]):
            tracks = parts.update(points(part, k * FRAME))
            assert tracks.restarted == ''
        for name in ('u', 'v', 'du', 'dv', 'state', 'hits', 'age', 'time_since_update'):
            np.testing.assert_allclose(
                np.sort(tracks.rows[name]), np.sort(rows[name]), rtol=0.02, atol=1e-9
            )


@pytest.mark.parametrize(('first', 'then', 'told'), [(0.6, 0.7, 1), (0.6, 300, 0), (300, 0.6, 0)])
def test_positions_that_are_shares_of_the_picture_are_told_once(first, then, told):
    tracker, reasons = Tracker(TrackerConfig(image_size=(640, 480))), []
    tracker.screening.refuse = reasons.append
    for k in range(60):
        tracker.update(points([(first if k < 5 else then, 0.5), (0.1, 0.2)], k * FRAME))
    assert len(reasons) == told
    assert all('expected px, got 0 to 1' in reason for reason in reasons)


@pytest.mark.parametrize(
    ('cameras', 'told'), [('llllllll', 0), ('llllrrrr', 0), ('lrlrlrlr', 6), ('llllrlll', 1)]
)
def test_detections_of_two_cameras_on_one_topic_are_told(cameras, told):
    tracker, reasons = Tracker(), []
    tracker.screening.refuse = reasons.append
    for k, camera in enumerate(cameras):
        tracker.update(replace(points([(10.0 + k, 10)], k * FRAME), frame_id=camera))
    assert len(reasons) == told
    assert all('expected one camera for each tracker' in reason for reason in reasons)


@pytest.mark.parametrize(
    ('count', 'colors', 'told'),
    [
        (6, lambda k: 6 * k + np.arange(6), 1),  # the row's number, of all so far
        (40, lambda _: np.arange(40), 0),  # as many classes, each seen once in a frame
        (6, lambda _: np.arange(6), 0),
        (1, lambda k: k // 2, 0),
        (6, lambda _: np.zeros(6), 0),
    ],
)
def test_colors_that_number_the_detections_are_told_once(count, colors, told):
    tracker, reasons = Tracker(), []
    tracker.screening.refuse = reasons.append
    z = np.stack([10.0 + 30 * np.arange(count), np.zeros(count)], axis=1)
    for k in range(60):
        detections = points(z, k * FRAME)
        detections.rows['color'] = colors(k)
        tracker.update(detections)
    assert len(reasons) == told
    assert all('expected one that a thing keeps' in reason for reason in reasons)


@pytest.mark.parametrize(
    ('scale', 'told'),
    [
        (lambda p: p, 0),
        (lambda p: np.minimum(p * 1.2, 1) + 1e-7, 0),
        (lambda p: np.log(p / (1 - p)), 1),
        (lambda p: p - 1, 1),
        (lambda p: 100 * p, 1),
        (lambda p: np.full(len(p), -1), 1),
    ],
    ids=['shares', 'rounded', 'logits', 'logarithms', 'percent', 'none'],
)
def test_scores_of_another_scale_are_told_once(scale, told):
    tracker, reasons, rng = Tracker(), [], np.random.default_rng(0)
    tracker.screening.refuse = reasons.append
    for k in range(60):
        detections = points([(10.0 + k, 10), (90, 200)], k * FRAME, size=(20, 40))
        detections.rows['score'] = scale(rng.uniform(0.1, 0.95, 2))
        tracks = tracker.update(detections)
    assert len(reasons) == told
    assert all('scores: expected 0 to 1' in reason for reason in reasons)
    assert tracks.rows['track_id'].tolist() == [1, 2]


@pytest.mark.slow
@pytest.mark.parametrize('stamp', [0, 5 * NANOSECONDS])
def test_a_stamp_that_never_changes_is_told_and_tracks_do_not_pile_up(stamp):
    tracker, reasons, most = Tracker(), [], 0
    tracker.screening.refuse = reasons.append
    for k in range(300):
        tracks = tracker.update(points([(10.0 + 3 * k, 10), (900 - 2 * k, 200)], stamp))
        most = max(most, len(tracks.rows))
    assert most <= 200
    assert 'expected a stamp for each frame' in reasons[0]
    assert tracker.screening.crowded_out == 400
    tracks = tracker.update(points([(10, 10)], stamp + FRAME))
    assert len(reasons) == 200
    assert not tracks.restarted


@pytest.mark.slow
def test_a_frame_in_a_message_for_each_of_its_objects_is_not_told():
    tracker, reasons = Tracker(), []
    tracker.screening.refuse = reasons.append
    for k in range(4):
        for i in range(60):
            tracks = tracker.update(points([(10.0 + k, 20.0 * i)], k * FRAME))
    assert not reasons
    assert len(tracks.rows) == 60


@pytest.mark.parametrize(
    'wrong',
    [
        lambda rows: rows[None],
        lambda rows: rows[:, None],
        lambda rows: rows[:0, None],
        lambda rows: rows[0],
        lambda rows: rows[['u', 'v', 'area']],
        lambda rows: rows.tolist(),
        lambda rows: np.ones((len(rows), 2)),
    ],
    ids=['(1, N)', '(N, 1)', '(0, 1)', 'one', 'few fields', 'tuples', 'numbers'],
)
def test_rows_of_another_shape_or_type_are_refused_with_what_they_should_be(wrong):
    rows, tracker = points([(10, 10), (50, 50)]).rows, Tracker()
    with pytest.raises(ValueError, match=r'expected an array .N,. of dtype DETECTION, got'):
        tracker.update(Detections(wrong(rows), 0))
    assert len(tracker.update(Detections(rows, FRAME)).rows) == 2


@pytest.mark.parametrize('then', [[], [50]])
def test_many_classes_of_one_picture_are_no_numbers(then):
    tracker, reasons = Tracker(), []
    tracker.screening.refuse = reasons.append
    for k, colors in enumerate([range(40), then, then, then]):
        detections = points(np.array([(30.0 * c, 10.0) for c in colors]).reshape(-1, 2), k * FRAME)
        detections.rows['color'] = list(colors)
        tracker.update(detections)
    assert not reasons


def test_what_is_in_the_padding_of_a_repeated_row_does_not_matter():
    tracker = Tracker()
    first = points([[10, 10], [50, 50]], FRAME)
    raw = bytearray(first.rows.tobytes())
    raw[68:72] = b'junk'
    tracker.update(first)
    tracks = tracker.update(Detections(np.frombuffer(raw, DETECTION), first.stamp))
    assert tracker.screening.repeated == len(tracks.rows) == 2


def test_a_repeated_message_is_refused_and_counted():
    once, twice = Tracker(), Tracker()
    for k in range(6):
        detections = points([(10 + k, 10), (200, 50)], k * FRAME)
        expected = once.update(detections).rows
        twice.update(detections)
        assert twice.update(detections).rows.tobytes() == expected.tobytes()
    assert twice.screening.repeated == 12


@pytest.mark.slow
def test_five_thousand_detections_in_one_frame_and_none_before_or_after():
    rng = np.random.default_rng(0)
    tracker = Tracker()
    for k in range(30):
        assert len(tracker.update(points([], k * FRAME)).rows) == 0
    tracks = tracker.update(points(rng.uniform(0, 4000, (5000, 2)), 30 * FRAME))
    assert len(tracks.rows) == 5000
    for k in range(31, 40):
        tracks = tracker.update(points([], k * FRAME))
    assert len(tracks.rows) == 0


@pytest.mark.parametrize('name', ['u', 'v', 'cov_uu', 'cov_uv', 'cov_vv', 'area', 'box_w'])
@pytest.mark.parametrize('value', [np.nan, np.inf])
def test_a_row_that_is_not_finite_is_dropped_and_counted(name, value):
    tracker = Tracker()
    detections = points([(1, 1), (200, 200)])
    detections.rows[name][0] = value
    with pytest.warns(UserWarning, match='refused: detections: expected') as told:
        assert tracker.update(detections).rows['u'].tolist() == [200]
    ours = [warning for warning in told if warning.category is UserWarning]
    assert [warning.filename for warning in ours] == [__file__]
    assert tracker.screening.dropped == 1


def test_a_covariance_that_is_none_is_dropped_and_counted():
    tracker = Tracker()
    detections = points([(1, 1), (50, 50), (99, 99)], variance=1.0)
    detections.rows['cov_uv'][0], detections.rows['cov_vv'][1] = 1.5, -1.0
    with pytest.warns(UserWarning, match='expected .* a positive definite or zero covariance'):
        assert tracker.update(detections).rows['u'].tolist() == [99]
    assert tracker.screening.dropped == 2


def test_of_too_many_detections_the_largest_are_taken_and_the_others_counted():
    tracker = Tracker(TrackerConfig(max_detections=3))
    detections = points([(100.0 * k, 50) for k in range(6)], 0)
    detections.rows['area'] = [1, 9, 2, 8, 7, 3]
    with pytest.warns(UserWarning, match='the smallest detections: expected max_detections=3'):
        assert tracker.update(detections).rows['u'].tolist() == [100, 300, 400]
    assert tracker.screening.crowded_out == 3
    assert tracker.screening.dropped == 0


def test_detections_that_crowd_on_one_point_do_not_hold_up_the_others():
    """A crowd of N has N^2 pairs; 3000 took 23 s, and half of them takes a tenth of that."""
    tracker, rng = Tracker(), np.random.default_rng(0)
    start = time.process_time()
    for k in range(3):
        crowd = [(300, 300), *rng.normal((900, 500), 0.1, (1500, 2))]
        rows = tracker.update(points([(float(u), float(v)) for u, v in crowd], k * FRAME)).rows
    assert time.process_time() - start < 8
    assert (rows['track_id'][0], rows['hits'][0]) == (1, 3)
