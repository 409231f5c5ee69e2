"""Errors of measurement that last longer than a frame, and how much of them differences show.

Of errors with the autocorrelation rho^k after k frames (shading that moves along, boxes that a
network regresses) neighboring measurements share a part, which their differences do not show.
Third differences of measurements two and three frames apart show more of it, by ratios that motion
does not have: those of white acceleration grow with the cube of the distance.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import hyp2f1

Floats = NDArray[np.float64]

RHO = np.array([0.0, 0.3, 0.5, 0.7, 0.8, 0.9])
"""Autocorrelations from frame to frame that are compared. Those above cannot be told from a random
walk of the object in the second or so in which it is straight."""

SHARES = np.linspace(0.05, 1.0, 20)
"""Shares of errors in the differences of neighbors that are compared; the rest is motion."""

WHITE_PRIOR = 0.9
"""Probability that errors are white, before any are seen. Assumed: lasting errors are proven."""

LOG_VARIANCES = np.array([1.07, 1.9])
"""Of one look: of the mean log of the squared differences at two and at three frames, less that of
neighbors. Found by drawing white normal errors; those with rho 0.9 have 1.02 and 2.04."""

COSINE_VARIANCE = 1.68
"""Of one difference's rise, see noise.MeasurementNoise; found alike, with 1.82 for rho 0.9."""

REDUNDANCY = 1.5
"""Of the three statistics, which are of the same measurements: together they tell two thirds of
what they would if they were independent. Assumed."""

BINOMIAL = np.array([1.0, -3.0, 3.0, -1.0])
"""Weights of a third difference."""


def mean_cosine(correlation: Floats) -> Floats:
    """Of the angle between two normal vectors in the plane, of that correlation by axis."""
    return np.asarray(np.pi / 4 * correlation * hyp2f1(0.5, 0.5, 2.0, correlation**2))


def _covariances(apart: int) -> Floats:
    """Of third differences with those 0, 1 and 2 frames before, over the errors', (3, RHO)."""
    at = apart * np.arange(4)
    lag = np.abs(at[:, None] - at - np.arange(3)[:, None, None])
    return np.einsum('i,j,kijr->kr', BINOMIAL, BINOMIAL, RHO ** lag[..., None])


_NEIGHBORS = _covariances(1)
SHOWN_BY_NEIGHBORS = _NEIGHBORS[0] / _NEIGHBORS[0, 0]
"""Share of the variance of errors that differences of neighbors show, by RHO."""

RISES = np.diff(mean_cosine(_NEIGHBORS[1:] / _NEIGHBORS[0]), axis=0)[0]
"""Mean cosine between third differences two frames apart, less that one frame apart, of errors
alone, by RHO."""

WANDERING = float(np.diff(mean_cosine(np.array([-1 / 3, -1 / 6])))[0])
"""The same of white acceleration alone."""

_MOTION = (1 - SHARES)[:, None]
_LOG_GROWTHS = [
    np.log(SHARES[:, None] * _covariances(apart)[0] / _NEIGHBORS[0] + _MOTION * apart**3)
    for apart in (2, 3)
]
_MIXED_RISES = SHARES[:, None] * RISES + _MOTION * WANDERING


def weigh(looks: Floats, growths: Floats, count: Floats, rise: Floats) -> Floats:
    """Probabilities of RHO, (C, RHO), of C colors.

    What is not proven counts as white: lasting errors have none where white ones are likelier.

    :param looks: (C,) how many there were.
    :param growths: (C, 2) mean log of the squared differences at two and at three frames, less that
        of neighbors.
    :param count: (C,) of differences.
    :param rise: (C,) their mean rise, see RISES.
    """
    d2 = count * (rise - _MIXED_RISES[..., None]) ** 2 / COSINE_VARIANCE
    for growth, expected, variance in zip(growths.T, _LOG_GROWTHS, LOG_VARIANCES, strict=True):
        d2 += looks * (growth - expected[..., None]) ** 2 / variance
    likelihood = np.exp((d2.min(axis=(0, 1)) - d2) / (2 * REDUNDANCY)).sum(axis=0)
    prior = np.where(RHO > 0, (1 - WHITE_PRIOR) / (len(RHO) - 1), WHITE_PRIOR)
    weight = prior[:, None] * likelihood
    weight /= weight.sum(axis=0)
    proven = np.maximum(1 - 2 * weight[0], 0.0)
    weight[1:] *= proven / np.maximum(weight[1:].sum(axis=0), 1e-9)
    weight[0] = 1 - proven
    return weight.T


def in_means(count: Floats) -> Floats:
    """Variance of the mean of so many measurements, over that with white errors, (..., RHO).

    :param count: of any shape, at least 1.
    """
    n, rest = count[..., None], 1 - RHO
    return np.asarray((1 + RHO) / rest - 2 * RHO * (1 - RHO**n) / (n * rest * rest))
