"""The probes that learn the process noise, against the Riccati equation."""

import numpy as np
import pytest

from colortrack_ros.tracking.process_noise import ALPHA
from colortrack_ros.tracking.process_noise import BETA
from colortrack_ros.tracking.process_noise import INDICES


@pytest.mark.slow
@pytest.mark.parametrize('probe', range(len(INDICES)))
def test_gains_are_in_the_end_those_of_a_kalman_filter_of_white_noise_acceleration(probe):
    F = np.array([[1, 1], [0, 1]])
    Q = INDICES[probe] * np.array([[1 / 3, 1 / 2], [1 / 2, 1]])
    P = 1e3 * np.eye(2)
    for _ in range(5000):
        P = F @ P @ F.T + Q
        K = P[:, 0] / (P[0, 0] + 1)
        P = P - np.outer(K, P[0])
    np.testing.assert_allclose([ALPHA[-1, probe], BETA[-1, probe]], K, rtol=1e-6)


@pytest.mark.parametrize('count', [2, 3, 5, 10])
def test_what_is_straight_is_fitted_by_least_squares_at_first(count):
    k = np.arange(count)
    x = np.random.default_rng(count).normal(size=count)
    place, speed = x[0], 0.0
    for n in range(1, count):
        place += speed
        alpha, beta = ALPHA[n + 1, 0], BETA[n + 1, 0]
        error = x[n] - place
        place, speed = place + alpha * error, speed + beta * error
    slope, offset = np.polyfit(k, x, 1)
    np.testing.assert_allclose([place, speed], [offset + slope * k[-1], slope], rtol=1e-9)
