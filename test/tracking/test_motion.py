"""Objects that cross, fall, rest and start, with each motion model."""

from dataclasses import replace

import numpy as np
import pytest
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.data import CONFIRMED
from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.association import ASSOCIATORS


def test_a_new_motion_model_starts_afresh_and_says_so():
    tracker = Tracker()
    tracker.update(points([(1, 1)], 0))
    tracker.configure(replace(tracker.config, motion_model='imm'))
    tracks = tracker.update(points([(1, 1)], FRAME))
    assert tracks.restarted == 'motion_model changed from constant_velocity to imm'
    assert tracks.rows['track_id'].tolist() == [2]


@pytest.mark.slow
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


@pytest.mark.slow
def test_an_object_that_has_rested_long_is_not_lost_when_it_starts():
    tracker = Tracker()
    for k in range(400):
        z = [(200 + 8 * max(0, k - 360), 100), (50, 300)]
        rows = tracker.update(points(z, k * FRAME, 0.01)).rows
    assert rows['track_id'].tolist() == [1, 2]
    np.testing.assert_allclose(rows['u'], [z[0][0], 50], atol=1)


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(2, 8))
def test_what_a_first_detection_could_not_decide_three_do(seed):
    """In clutter a lost object is recognized by its velocity, not by a single detection."""
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
