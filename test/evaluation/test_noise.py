import numpy as np
import pytest

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
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
