"""Lines: least squares through the detections of rivals after they have separated."""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.records import Records
from colortrack_ros.tracking.hypotheses import Hypotheses


def add_to_lines(records: Records, pairs: Hypotheses, stamp: int) -> None:
    """Add the measurements of separated rivals to the sums of their lines."""
    mine = (records['rival'][pairs.track] > 0) & (records['apart'][pairs.track] < stamp)
    track, z, R = pairs.track[mine], pairs.z[mine], pairs.R[mine]
    t = (stamp - records['apart'][track]) / NANOSECONDS
    weight = 2 / (R[:, 0, 0] + R[:, 1, 1])
    u, v = z.T
    records['sums'][track] += (weight * np.array([np.ones(len(t)), t, t * t, u, v, t * u, t * v])).T
    records['scans'][track] += 1


def fit_lines(records: Records, track: Indices, stamp: int) -> tuple[Floats, Floats]:
    """Weighted least squares: states (K, 4) at the stamp, and their covariances (K, 4, 4)."""
    t = (stamp - records['apart'][track]) / NANOSECONDS
    s, st, stt, *sums = records['sums'][track].T
    det = s * stt - st * st
    mean, cov = np.zeros((len(track), 4)), np.zeros((len(track), 4, 4))
    for axis in range(2):
        z, tz = sums[axis], sums[axis + 2]
        speed = (s * tz - st * z) / det
        mean[:, axis] = (z - speed * st) / s + speed * t
        mean[:, axis + 2] = speed
        cov[:, axis, axis] = (stt - 2 * st * t + s * t * t) / det
        cov[:, axis, axis + 2] = cov[:, axis + 2, axis] = (s * t - st) / det
        cov[:, axis + 2, axis + 2] = s / det
    return mean, cov


def coasted(mean: Floats, cov: Floats, T: Floats, q: float) -> tuple[Floats, Floats]:
    """States (K, 4) and covariances (K, 4, 4) after T, (K,) [s]; see ConstantVelocity.

    :param q: density of the process noise [px^2/s^3].
    """
    F = np.zeros((len(T), 4, 4))
    F[:] = np.eye(4)
    F[:, (0, 1), (2, 3)] = T[:, None]
    mean, cov = (F @ mean[..., None])[..., 0], F @ cov @ F.swapaxes(1, 2)
    for i, j, gain in ((0, 0, T**3 / 3), (0, 2, T**2 / 2), (2, 0, T**2 / 2), (2, 2, T)):
        cov[:, (i, i + 1), (j, j + 1)] += q * gain[:, None]
    return mean, cov
