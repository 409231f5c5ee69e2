import numpy as np
import pytest

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.evaluation.noise import innovations_of
from colortrack_ros.evaluation.noise import noise_of


def filtered(sigma, count=3000, state=CONFIRMED):
    """A random walk measured with noise, and the posterior of its Kalman filter."""
    rng = np.random.default_rng(0)
    x = np.cumsum(rng.normal(0, 1.0, (count, 2)), axis=0)
    z = x + rng.normal(0, sigma, (count, 2))
    m, P = z[0], sigma**2
    for k in range(1, count):
        P += 1.0
        K = P / (P + sigma**2)
        m, P = m + K * (z[k] - m), (1 - K) * P
        track, detection = np.zeros(1, TRACK), np.zeros(2, DETECTION)
        track['u'], track['v'], track['state'] = *m, state
        track['covariance'] = P * np.eye(4)
        detection['u'], detection['v'] = z[k][0], z[k][1]
        detection['cov_uu'] = detection['cov_vv'] = 4.0
        track['area'], detection['area'] = 50 + k % 7, (50 + k % 7, 500)
        detection['u'][1] += 30
        yield Tracks(track), Detections(detection)


@pytest.mark.parametrize('sigma', [0.5, 3.0])
def test_the_noise_of_measurements_is_told_by_the_tracks_made_of_them(sigma):
    assert noise_of(filtered(sigma)) == {
        'noise': pytest.approx(sigma, rel=0.05),
        'noise_claimed': pytest.approx(2.0),
    }


def test_tracks_that_took_no_detection_tell_nothing():
    assert noise_of(filtered(1.0, 50, COASTING)) == {}
    assert noise_of([(Tracks(), Detections())]) == {}


def moving(sigma, claimed, count=2000):
    """A constant velocity measured with noise, and the filter that believes what is claimed."""
    rng = np.random.default_rng(1)
    dt, H = 0.1, np.eye(2, 4)
    F = np.eye(4) + dt * np.eye(4, k=2)
    x, P, R = np.array([0, 0, 10.0, 5.0]), 1e2 * np.eye(4), claimed**2 * np.eye(2)
    for k in range(count):
        z = np.array([1.0, 0.5]) * k + rng.normal(0, sigma, 2)
        x, P = F @ x, F @ P @ F.T + 1e-4 * np.eye(4)
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        x, P = x + K @ (z - H @ x), P - K @ H @ P
        track, detection = np.zeros(1, TRACK), np.zeros(1, DETECTION)
        track['u'], track['v'], track['du'], track['dv'] = x
        track['covariance'], track['state'], track['track_id'] = P, CONFIRMED, 7
        detection['u'], detection['v'] = z
        detection['cov_uu'] = detection['cov_vv'] = claimed**2
        stamp = round(k * dt * 1e9)
        yield Tracks(track, stamp), Detections(detection, stamp)


@pytest.mark.slow
def test_innovations_tell_whether_the_covariances_are_right():
    right = innovations_of(moving(2.0, 2.0))
    assert right['nis'] == pytest.approx(1.0, abs=0.1)
    assert right['nis_coverage'] == pytest.approx(0.95, abs=0.02)
    assert innovations_of(moving(2.0, 1.0))['nis'] > 3
    assert innovations_of(moving(2.0, 8.0))['nis'] < 0.2
    assert innovations_of([]) == {}
