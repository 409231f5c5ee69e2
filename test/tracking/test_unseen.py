"""The published covariance of what is out of sight, against its model sampled."""

import math

import numpy as np
import pytest

from colortrack_ros.data import TRACK
from colortrack_ros.tracking.records import _unseen

COUNT = 400_000


def sampled(P, velocity, density, rate, T, speed):
    """Second moment of a coasting object's state about its prediction without a maneuver.

    :param density: of its additional white acceleration, (2,) [px^2/s^3].
    :param rate: of maneuvers [1/s], each to a velocity N(0, speed^2), at any time in T.
    """
    rng = np.random.default_rng(0)
    off = rng.multivariate_normal(np.zeros(4), P, COUNT)
    for axis in range(2):
        Q = density[axis] * np.array([[T**3 / 3, T**2 / 2], [T**2 / 2, T]])
        off[:, axis::2] += rng.multivariate_normal(np.zeros(2), Q, COUNT)
    turned = np.flatnonzero(rng.random(COUNT) < -math.expm1(-rate * T))
    left = T * rng.random(len(turned))[:, None]
    new = rng.normal(0, speed, (len(turned), 2))
    off[turned, :2] += (new - velocity) * left
    off[turned, 2:] = new - velocity
    return off.T @ off / COUNT


@pytest.mark.parametrize('T', [0.2, 1.0])
@pytest.mark.parametrize(('rate', 'density'), [(0.0, (900.0, 100.0)), (0.7, (0.0, 0.0))])
def test_what_is_unseen_is_where_maneuvers_and_accelerations_may_have_taken_it(T, rate, density):
    P, velocity, speed = (
        np.diag([2.0, 3.0, 4.0, 5.0]),
        np.array([80.0, -30.0]),
        np.array([60, 90]),
    )
    rows = np.zeros(1, TRACK)
    rows['time_since_update'], rows['covariance'] = T, P
    rows['du'], rows['dv'] = velocity
    got = _unseen(rows, np.array([density]), np.array([rate]), speed if rate else np.zeros(2))[0]
    expected = sampled(P, velocity, density, rate, T, speed)
    scale = np.sqrt(np.outer(expected.diagonal(), expected.diagonal()))
    np.testing.assert_allclose(got / scale, expected / scale, atol=0.02)
