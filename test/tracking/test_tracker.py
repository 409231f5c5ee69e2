from dataclasses import replace
import time

from hypothesis import example
from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import TRACK
from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.association import ASSOCIATORS

PEGORETTI = TrackerConfig(
    process_noise=1.0,
    measurement_noise=1.0,
    detection_covariance=False,
    centroid_bias=0.0,
    use_boxes=False,
    initial_speed=1.0,
    maneuvers=False,
    gating=False,
    confirm_hits=1,
    confirm_window=1,
    min_score=0.0,
)


def textbook(z, dt, sigma_s=1.0, sigma_w=1.0, speed=1.0):
    """Pegoretti 2021, (2.19)-(2.32), in the order (u, v, du, dv), Joseph form.

    But for Q, which is that of continuous white noise (Bar-Shalom et al. 2001, 6.2.2).
    """
    F = np.eye(4)
    F[0, 2] = F[1, 3] = dt
    H = np.eye(2, 4)
    Q = sigma_s**2 / 30 * np.kron([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]], np.eye(2))
    x, P = H.T @ z[0], np.diag([sigma_w**2, sigma_w**2, speed**2, speed**2])
    for one in z[1:]:
        x, P = F @ x, F @ P @ F.T + Q
        if one is not None:
            K = P @ H.T @ np.linalg.inv(H @ P @ H.T + sigma_w**2 * np.eye(2))
            x = x + K @ (one - H @ x)
            A = np.eye(4) - K @ H
            P = A @ P @ A.T + sigma_w**2 * K @ K.T
    return x, P


@given(seed=st.integers(0, 2**32 - 1), period=st.integers(1_000_000, 400_000_000))
@example(seed=109179, period=301595299)  # far from its track at last
@settings(max_examples=30, deadline=None)
def test_a_lone_track_is_the_textbook_filter(seed, period):
    rng = np.random.default_rng(seed)
    z = [*rng.normal(0, 3, (20, 2))]
    for k in rng.integers(1, 20, 3):
        z[k] = None
    tracker = Tracker(PEGORETTI)
    for k, one in enumerate(z):
        rows = tracker.update(points([] if one is None else one, k * period)).rows
    x, P = textbook(z, period / NANOSECONDS)
    np.testing.assert_allclose([rows['u'][0], rows['v'][0], rows['du'][0], rows['dv'][0]], x)
    np.testing.assert_allclose(rows['covariance'][0], P, atol=1e-12)


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
    """The second brings what the first did not have; nobody is missed for not being in both."""
    whole, parts = Tracker(), Tracker()
    for k in range(12):
        z = np.array([(10.0 + k, 10), (200 - 2 * k, 50), (90, 90 + k)])
        rows = whole.update(points(z, k * FRAME)).rows
        for part in (z[:1], z[1:], z[:0]):
            tracks = parts.update(points(part, k * FRAME))
            assert tracks.restarted == ''
        for name in ('u', 'v', 'du', 'dv', 'state', 'hits', 'age', 'time_since_update'):
            np.testing.assert_allclose(np.sort(tracks.rows[name]), np.sort(rows[name]), rtol=0.02)


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


def test_a_new_motion_model_starts_afresh_and_says_so():
    tracker = Tracker()
    tracker.update(points([(1, 1)], 0))
    tracker.configure(replace(tracker.config, motion_model='imm'))
    tracks = tracker.update(points([(1, 1)], FRAME))
    assert tracks.restarted == 'motion_model changed from constant_velocity to imm'
    assert tracks.rows['track_id'].tolist() == [2]


@pytest.mark.parametrize('model', MOTION_MODELS)
@pytest.mark.parametrize('associator', ASSOCIATORS)
def test_every_model_with_every_associator_follows_crossing_objects(model, associator):
    tracker = Tracker(TrackerConfig(motion_model=model, associator=associator))
    rng = np.random.default_rng(5)
    for k in range(60):
        truth = np.array([(5.0 * k, 100 + 2 * k), (300 - 5 * k, 100 + 2 * k), (150, 400 - 4 * k)])
        seen = truth[rng.random(3) < 0.9] + rng.normal(0, 0.5, (3, 2))[:1]
        rows = tracker.update(points(seen, k * FRAME, 0.25)).rows
    np.testing.assert_allclose(np.stack([rows['u'], rows['v']], 1), truth, atol=4)
    assert rows['track_id'].tolist() == [1, 2, 3]


def test_gravity_as_a_known_acceleration_keeps_a_hidden_ball_on_its_path():
    errors = []
    for model in ('constant_velocity', 'known_acceleration'):
        config = TrackerConfig(motion_model=model, acceleration=(0, 900), process_noise=50.0)
        tracker = Tracker(config)
        for k in range(30):
            t = k / 24
            z = (100 * t, 500 - 600 * t + 450 * t**2)
            row = tracker.update(points([z] if k < 20 else [], k * FRAME, 0.01)).rows[0]
        errors.append(np.hypot(row['u'] - z[0], row['v'] - z[1]))
    assert errors[0] > 20
    assert errors[1] < 2


def test_an_object_that_has_rested_long_is_not_lost_when_it_starts():
    tracker = Tracker()
    for k in range(400):
        z = [(200 + 8 * max(0, k - 360), 100), (50, 300)]
        rows = tracker.update(points(z, k * FRAME, 0.01)).rows
    assert rows['track_id'].tolist() == [1, 2]
    np.testing.assert_allclose(rows['u'], [z[0][0], 50], atol=1)


@pytest.mark.parametrize('seed', range(2, 8))
def test_what_a_first_detection_could_not_decide_three_do(seed):
    """Amid clutter a lost object is not known again by one detection, but by its velocity."""
    tracker = Tracker()
    rng = np.random.default_rng(seed)
    ids = []
    for k in range(60):
        clutter = rng.uniform(0, 600, (6, 2))
        z = (50 + 6 * k, 300 + (12 if k >= 40 else 0))
        frame = clutter if 30 <= k < 40 else np.vstack([clutter, [z]])
        rows = tracker.update(points(frame, k * FRAME, 1.0)).rows
        near = np.hypot(rows['u'] - z[0], rows['v'] - z[1]) < 8
        if k in (29, 59):
            ids.append(rows['track_id'][near & (rows['state'] == CONFIRMED)].tolist())
    assert ids[0] == ids[1] != []


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
    """At 4 px a frame, to the right; seen until u = 96. What is typed in holds."""
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
    """They rest side by side, and are once seen a little past each other."""
    found = []
    for gating in (True, False):
        tracker = Tracker(TrackerConfig(color_gating=gating))
        for k, (one, other) in enumerate([(100, 104)] * 5 + [(102.2, 101.8)]):
            detections = points([(one, 50), (other, 50)], k * FRAME, 25.0)
            detections.rows['color'] = [0, 1]
            rows = tracker.update(detections).rows
        found.append(rows[['u', 'v', 'color']].tolist())
    assert found[0] == found[1]


@pytest.mark.parametrize('name', ['u', 'v', 'cov_uu', 'cov_uv', 'cov_vv', 'area', 'box_w'])
@pytest.mark.parametrize('value', [np.nan, np.inf])
def test_a_row_that_is_not_finite_is_dropped_and_counted(name, value):
    tracker = Tracker()
    detections = points([(1, 1), (200, 200)])
    detections.rows[name][0] = value
    assert tracker.update(detections).rows['u'].tolist() == [200]
    assert tracker.screening.dropped == 1


def test_a_covariance_that_is_none_is_dropped_and_counted():
    tracker = Tracker()
    detections = points([(1, 1), (50, 50), (99, 99)], variance=1.0)
    detections.rows['cov_uv'][0], detections.rows['cov_vv'][1] = 1.5, -1.0
    assert tracker.update(detections).rows['u'].tolist() == [99]
    assert tracker.screening.dropped == 2


def test_the_same_messages_give_the_same_tracks_to_the_bit():
    rng = np.random.default_rng(3)
    frames = [points(rng.uniform(0, 300, (9, 2)), k * FRAME, 0.5) for k in range(30)]
    one, two = Tracker(), Tracker()
    for detections in frames:
        rows = one.update(detections).rows
        assert rows.tobytes() == two.update(detections).rows.tobytes()
        assert len(rows) >= 9


def test_as_in_the_document_a_false_detection_takes_somebodys_filter():
    """3.1.2 has neither gate nor cost of a miss; with both, the track coasts."""
    for config, ids in ((PEGORETTI, [1]), (TrackerConfig(), [1, 2])):
        tracker = Tracker(config)
        for k in range(5):
            tracker.update(points([(50, 50)], k * FRAME))
        rows = tracker.update(points([(400, 300)], 5 * FRAME)).rows
        assert rows['track_id'].tolist() == ids


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


def test_of_too_many_detections_the_largest_are_taken_and_the_others_counted():
    tracker = Tracker(TrackerConfig(max_detections=3))
    detections = points([(100.0 * k, 50) for k in range(6)], 0)
    detections.rows['area'] = [1, 9, 2, 8, 7, 3]
    assert tracker.update(detections).rows['u'].tolist() == [100, 300, 400]
    assert tracker.screening.crowded_out == 3
    assert tracker.screening.dropped == 0


def test_detections_that_crowd_on_one_point_do_not_hold_up_the_others():
    """A crowd of N has N^2 pairs; they took 23 s for 3000, and take a tenth for half of them."""
    tracker, rng = Tracker(), np.random.default_rng(0)
    start = time.process_time()
    for k in range(3):
        crowd = [(300, 300), *rng.normal((900, 500), 0.1, (1500, 2))]
        rows = tracker.update(points([(float(u), float(v)) for u, v in crowd], k * FRAME)).rows
    assert time.process_time() - start < 8
    assert (rows['track_id'][0], rows['hits'][0]) == (1, 3)
