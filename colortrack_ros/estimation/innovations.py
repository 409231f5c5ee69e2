"""Innovations: measurements against the predictions of a bank of filters."""

from dataclasses import dataclass

import numpy as np

from colortrack_ros.columns import Columns
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.gaussian import log_density
from colortrack_ros.estimation.gaussian import TINY


@dataclass
class Innovations(Columns):
    """Innovations of K pairs of a measurement and a track.

    :param log_likelihood: (K,) log of the density of the measurement [1/px^2].
    :param maneuvered: (K,) posterior probability that the track has maneuvered, if the measurement
        is the track's.
    """

    log_likelihood: Floats
    maneuvered: Floats


def compare(
    bank: Bank, track: Indices, z: Floats, R: Floats, chance: Floats, T: Floats, speed: Floats
) -> Innovations:
    """Compare measurements with predictions, with and without a maneuver.

    Log of N(z; H x, S), S = H P H^T + R, a weighted sum over the modes and over both cases. The
    determinant counts: uncertain predictions pay for it.

    :param track: (K,) tracks.
    :param z: (K, 2) measurement [px].
    :param R: (K, 2, 2) its covariance [px^2].
    :param chance: (K,) prior probability of a maneuver.
    :param T: (K,) time in which it may have happened [s], see Bank.maneuver().
    :param speed: (2,), (1, 2), or (K, 2) standard deviation of a new velocity on each axis [px/s].
    """
    mean, cov = bank.mean.take(track, axis=1), bank.cov.take(track, axis=1)
    e, S = np.empty((2, *mean.shape[:2], 2)), np.empty((2, *mean.shape[:2], 2, 2))
    way = mean[..., 2:4] * (T / 2.0)[:, None]
    np.subtract(z, mean[..., :2], out=e[0])
    np.add(e[0], way, out=e[1])
    np.add(cov[..., :2, :2], R, out=S[0])
    np.add(S[0], way[..., :, None] * way[..., None, :] / 3.0, out=S[1])
    S[1].reshape(*mean.shape[:2], 4)[..., ::3] += speed**2 * (T**2 / 3.0)[:, None]
    going_on, turning = log_density(e, S)
    going_on += np.log1p(-chance)
    turning += np.log(np.maximum(chance, TINY))
    if bank.model.modes > 1:
        weight = np.log(np.maximum(bank.weight.take(track, axis=1), TINY))
        going_on, turning = going_on + weight, turning + weight
        going_on, turning = (np.logaddexp.reduce(log, axis=0) for log in (going_on, turning))
    else:
        going_on, turning = going_on[0], turning[0]
    total = np.logaddexp(going_on, turning)
    return Innovations(total, np.exp(turning - total))
