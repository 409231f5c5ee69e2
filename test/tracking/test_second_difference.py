"""The acceleration by second differences, and the gains of the two filters: Red object, (13)."""

import numpy as np
import pytest
from support.silhouettes import points

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.second_difference import ACCELERATION_FIELDS
from colortrack_ros.tracking.second_difference import learn_acceleration

FRAME = NANOSECONDS // 24
GRAVITY = np.array([30.0, 900.0])


def parabola(t):
    return np.array([20.0, 500.0]) + np.array([100.0, -600.0]) * t + GRAVITY / 2 * t * t


def last_error(seen, hidden, **parameters):
    """Return the position error of a ball in flight after frames seen and frames hidden."""
    tracker = Tracker(TrackerConfig(process_noise=50.0, **parameters))
    for k in range(seen + hidden):
        z = parabola(k / 24)
        row = tracker.update(points([z] if k < seen else [], k * FRAME, 0.01)).rows[0]
    return np.hypot(row['u'] - z[0], row['v'] - z[1])


@pytest.mark.parametrize('model', ['known_acceleration', 'switched_pair'])
def test_a_hidden_ball_goes_on_with_the_acceleration_of_its_past_positions(model):
    assert last_error(20, 10, motion_model=model) > 20
    assert last_error(20, 10, motion_model=model, acceleration_span=0.12) < 3


def test_the_acceleration_is_that_of_the_parabola_at_irregular_stamps():
    random = np.random.default_rng(0)
    records = np.zeros(3, ACCELERATION_FIELDS)
    stamp = np.cumsum(random.integers(1, 200, 60)) * NANOSECONDS // 1000
    for k, now in enumerate(stamp.tolist()):
        track = np.array([0, 2]) if k % 3 else np.array([0])
        z = np.tile(parabola(now / NANOSECONDS), (len(track), 1))
        learn_acceleration(records, track, z, now, 0.15)
    np.testing.assert_allclose(records['acceleration'], [GRAVITY, (0, 0), GRAVITY], rtol=1e-6)


def test_positions_closer_than_the_span_are_not_compared():
    records = np.zeros(1, ACCELERATION_FIELDS)
    for now, u in ((0, 0.0), (40, 50.0), (100, 1.0), (140, 90.0), (200, 4.0)):
        learn_acceleration(records, np.array([0]), np.array([[u, 0.0]]), now * 10**6, 0.1)
    np.testing.assert_allclose(records['acceleration'], [(200.0, 0.0)])


def test_the_first_filter_follows_the_measurement_as_much_as_it_is_told_to():
    """A straight path, with the last measurement 10 px off."""
    aside = []
    for trust in (1.0, 10.0, 1000.0):
        config = TrackerConfig(
            motion_model='switched_pair', trust=(trust, 0.1), process_noise=50.0, maneuvers=False,
            gating=False,
        )  # fmt: skip
        tracker = Tracker(config)
        for k in range(40):
            row = tracker.update(points([(5 * k, 100 + 10 * (k == 39))], k * FRAME, 1.0)).rows[0]
        aside.append(row['v'] - 100)
    assert 0 < aside[0] < aside[1] < aside[2] < 10
    assert aside[2] > 9.5


@pytest.mark.parametrize(
    'change', [{'trust': (5.0, 0.1)}, {'acceleration': (0.0, 9.0)}], ids=['trust', 'acceleration']
)
def test_other_gains_or_another_acceleration_begin_with_no_tracks(change):
    tracker = Tracker(TrackerConfig(motion_model='switched_pair'))
    for k in range(5):
        tracker.update(points([(5 * k, 100)], k * FRAME, 1.0))
    tracker.configure(TrackerConfig(motion_model='switched_pair', **change))
    tracks = tracker.update(points([(25, 100)], 5 * FRAME, 1.0))
    assert next(iter(change)) in tracks.restarted
    assert tracks.rows['track_id'].tolist() == [2]
