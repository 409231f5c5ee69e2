"""Gaussians in arrays: updates, mixtures, maneuvers, 2x2 inverses."""

import numpy as np

from colortrack_ros.data import Floats

LOG_2PI = float(np.log(2 * np.pi))

TINY = 1e-300
"""Keeps logarithms and quotients of probabilities finite; close to the smallest positive double."""

NEARLY_SINGULAR = 1e-14
"""Least determinant of a 2x2 covariance over the product of its variances. Tracks that are very
uncertain in one direction only have less than rounding, 2e-16 of the product, leaves intact."""


def log_density(e: Floats, S: Floats) -> Floats:
    """Log of N(e; 0, S), (...), for e (..., 2) and S (..., 2, 2)."""
    x, y = e[..., 0], e[..., 1]
    a, b, c = S[..., 0, 0], S[..., 0, 1], S[..., 1, 1]
    det = _determinant(a, b, c)
    d2 = (c * x * x - 2.0 * b * x * y + a * y * y) / det
    log: Floats = -0.5 * (d2 + np.log(det)) - LOG_2PI
    return log


def _determinant(a: Floats, b: Floats, c: Floats) -> Floats:
    """Determinants of covariances [[a, b], [b, c]]."""
    product = a * c
    return np.maximum(product - b * b, NEARLY_SINGULAR * product)


def joseph(P: Floats, K: Floats, R: Floats) -> Floats:
    """Covariance after an update with any gain: (I - KH) P (I - KH)^T + K R K^T.

    With H = [I 0] and A = (I - KH) P it is A + (K R - A H^T) K^T.

    :param P: (..., n, n); K: (..., n, 2); R: (..., 2, 2).
    """
    P = P - K @ P[..., :2, :]
    P += (K @ R - P[..., :2]) @ K.swapaxes(-1, -2)
    P = (P + P.swapaxes(-1, -2)) / 2.0
    return P


def normalized(log_weight: Floats) -> Floats:
    """Return log weights, (C, ...), of which the weights have the sum 1 over the first axis.

    :param log_weight: the largest is about 0, so that none of importance underflows.
    """
    return np.asarray(log_weight - np.log(np.exp(log_weight).sum(axis=0)))


def mixture(weight: Floats, mean: Floats, cov: Floats) -> tuple[Floats, Floats]:
    """Mean and covariance of Gaussian mixtures over the first axis.

    :param weight: (M, ...), of sum 1; mean: (M, ..., n); cov: (M, ..., n, n).
    """
    weight = weight[..., None]
    center = np.add.reduce(weight * mean)
    rest = mean - center
    outer = rest[..., :, None] * rest[..., None, :]
    return center, np.add.reduce(weight[..., None] * (cov + outer))


def turned(mean: Floats, cov: Floats, T: Floats, speed: Floats) -> tuple[Floats, Floats]:
    """Predictions after a maneuver.

    A maneuver draws a new velocity from N(0, speed^2) at a time t uniformly distributed over the
    last T. From then on the position moves with the new velocity instead of the old one, v: with
    T - t of mean T/2, mean square T^2/3 and variance T^2/12, it shifts by -v T/2 and gains the
    covariance v v^T T^2/12 + speed^2 T^2/3, correlated with the velocity.

    :param mean, cov: (..., K, n) and (..., K, n, n) without it.
    :param T: (K,) [s].
    :param speed: (2,), (1, 2), or (K, 2) standard deviation of the new velocity [px/s].
    """
    mean, cov = mean.copy(), cov.copy()
    half = mean[..., 2:4] * (T / 2.0)[:, None]
    mean[..., :2] -= half
    mean[..., 2:] = 0.0
    cov[..., 2:4, :] = cov[..., :, 2:4] = 0.0
    cov[..., :2, :2] += half[..., :, None] * half[..., None, :] / 3.0
    n, variance = cov.shape[-1], speed**2
    entries = cov.reshape(*cov.shape[:-2], n * n)
    both, T = n + 1, T[:, None]  # from an entry of u to that of v
    entries[..., : 2 * both : both] += (speed * T) ** 2 / 3.0
    with_velocity = variance * T / 2.0
    entries[..., 2 : 2 + 2 * both : both] = with_velocity
    entries[..., 2 * n : 2 * n + 2 * both : both] = with_velocity
    entries[..., 2 * both : 4 * both : both] = variance
    return mean, cov


def maneuvering(
    mean: Floats, cov: Floats, chance: Floats, T: Floats, speed: Floats
) -> tuple[Floats, Floats]:
    """Mean and covariance of the mixture of predictions with and without a maneuver.

    :param mean, cov: (..., K, n) and (..., K, n, n) without it.
    :param chance: (K,) probability of a maneuver; T, speed: see turned().
    """
    new_mean, new_cov = turned(mean, cov, T, speed)
    aside = new_mean - mean
    between = (chance * (1.0 - chance))[:, None, None] * aside[..., :, None] * aside[..., None, :]
    new_cov -= cov
    new_cov *= chance[:, None, None]
    return mean + chance[:, None] * aside, cov + new_cov + between


def invert(S: Floats) -> tuple[Floats, Floats]:
    """Inverse and determinant of symmetric 2x2 matrices.

    :param S: (..., 2, 2).
    :return: (..., 2, 2) and (...).
    """
    a, b, c = S[..., 0, 0], S[..., 0, 1], S[..., 1, 1]
    det = _determinant(a, b, c)
    inverse = np.empty_like(S)
    inverse[..., 0, 0], inverse[..., 1, 1] = c / det, a / det
    inverse[..., 0, 1] = inverse[..., 1, 0] = -b / det
    return inverse, det
