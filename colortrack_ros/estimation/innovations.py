"""How measurements compare with what a bank of filters predicts of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Columns
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.gaussian import log_density
from colortrack_ros.estimation.gaussian import TINY

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Innovations(Columns):
    """How K measurements compare with what was predicted of their tracks.

    Of the likeliest mode, going on, are nis, predicted_share and innovation.

    :param log_likelihood: (K,) log of the density of the measurement [1/px^2].
    :param maneuvered: (K,) probability that the track has maneuvered, if the measurement is its.
    :param nis: (K,) innovation squared, normalized by its covariance S.
    :param predicted_share: (K,) share of the prediction in S, 0..1; the rest is R.
    :param innovation: (K, 2) over the fourth root of det S.
    """

    log_likelihood: Floats
    maneuvered: Floats
    nis: Floats
    predicted_share: Floats
    innovation: Floats


def compare(
    bank: Bank, track: Indices, z: Floats, R: Floats, chance: Floats, T: Floats, speed: Floats
) -> Innovations:
    """Compare measurements with the predictions of tracks that go on or have maneuvered.

    Log of N(z; H x, S), S = H P H^T + R, summed over the modes by their weights, and over going on
    and maneuvering. The determinant counts: what is uncertain pays.

    :param track: (K,) which track.
    :param z: (K, 2) measurement [px].
    :param R: (K, 2, 2) its covariance [px^2].
    :param chance: (K,) probability of a maneuver.
    :param T: (K,) time that there was for it [s], see Bank.maneuver().
    :param speed: (2,) standard deviation of a new velocity on each axis [px/s].
    """
    mean, cov = bank.mean[:, track], bank.cov[:, track]
    x, y = z[:, 0] - mean[..., 0], z[:, 1] - mean[..., 1]
    p, q = mean[..., 2] * (T / 2), mean[..., 3] * (T / 2)
    S = cov[..., 0, 0] + R[:, 0, 0], cov[..., 0, 1] + R[:, 0, 1], cov[..., 1, 1] + R[:, 1, 1]
    d2, det, going_on = log_density(x, y, *S)
    s2, t2 = speed[:, None] ** 2, T**2 / 3
    S = S[0] + p * p / 3 + s2[0] * t2, S[1] + p * q / 3, S[2] + q * q / 3 + s2[1] * t2
    turning = log_density(x + p, y + q, *S)[2]
    going_on += np.log1p(-chance)
    turning += np.log(np.maximum(chance, TINY))
    best: tuple = (0,)
    if bank.model.modes > 1:
        weight = np.log(np.maximum(bank.weight[:, track], TINY))
        going_on, turning = going_on + weight, turning + weight
        best = going_on.argmax(axis=0), np.arange(len(track))
        going_on, turning = (np.logaddexp.reduce(log, axis=0) for log in (going_on, turning))
    else:
        going_on, turning = going_on[0], turning[0]
    total = np.logaddexp(going_on, turning)
    root = np.sqrt(det[best])
    predicted = 1 - np.sqrt(R[:, 0, 0] * R[:, 1, 1] - R[:, 0, 1] ** 2) / root
    e = np.array([x[best], y[best]]) / np.sqrt(root)
    return Innovations(total, np.exp(turning - total), d2[best], predicted, e.T)
