"""Lines through the detections of rivals are those of weighted least squares."""

from types import SimpleNamespace

import numpy as np

from colortrack_ros.tracking.crossings import _lines
from colortrack_ros.tracking.crossings import _sum_up
from colortrack_ros.tracking.records import FIELDS

SECOND = 1_000_000_000


def test_states_and_covariances_are_those_of_the_normal_equations():
    rng = np.random.default_rng(3)
    records = np.zeros(2, np.dtype(FIELDS))
    records['rival'] = 2, 1
    stamps = np.sort(rng.integers(1, SECOND, 6))
    z, sigma = rng.normal(0, 100, (6, 2, 2)), rng.uniform(0.5, 3, (6, 2))
    for stamp, measured, s in zip(stamps, z, sigma, strict=True):
        R = s[:, None, None] ** 2 * np.eye(2)
        _sum_up(records, SimpleNamespace(track=np.arange(2), z=measured, R=R), stamp)
    now = 2 * SECOND
    mean, cov = _lines(records, np.arange(2), now)
    for track in range(2):
        ages = (stamps - now) / SECOND
        H = np.stack([np.ones(6), ages], axis=1) / sigma[:, track, None]
        expected_cov = np.linalg.inv(H.T @ H)
        expected = expected_cov @ H.T @ (z[:, track] / sigma[:, track, None])
        np.testing.assert_allclose(mean[track].reshape(2, 2), expected, rtol=1e-6)
        np.testing.assert_allclose(cov[track], np.kron(expected_cov, np.eye(2)), rtol=1e-6)
    assert records['scans'].tolist() == [6, 6]
