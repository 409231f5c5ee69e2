"""Errors of measurement that last longer than a frame, and how much of them differences show.

Of errors with the autocorrelation rho^k after k frames (shading that moves along, boxes that a
network regresses) neighboring measurements share a part, which their differences do not show.
Third differences of measurements two and five frames apart show more of it, by ratios that motion
does not have: the squares of those of white acceleration grow with the cube of the distance, of a
smooth motion with its sixth power.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import hyp2f1

Floats = NDArray[np.float64]

RHO = np.array([0.0, 0.3, 0.5, 0.7, 0.8, 0.9])
"""Autocorrelations from frame to frame that are compared. Those above cannot be told from a random
walk of the object in the second or so in which it is straight."""

MOTION_SHARES = np.append(np.geomspace(0.95, 1e-5, 30), 0.0)
"""Shares of motion in the squared differences of neighbors that are compared; the rest is errors.
Smooth motion of which neighbors show 1e-5 is a sixth of the square five frames apart."""

WHITE_PRIOR = 0.92
"""Probability that errors are white, before any are seen. Assumed: lasting errors are proven; with
0.95 the ellipses of those with rho 0.3 to 0.9 hold 3 to 14 % less in the first three seconds."""

LOG_VARIANCES = np.array([1.18, 3.47])
"""For each look: of the mean log of the squared differences at two and at five frames, less that of
neighbors. Found by drawing long rows of white normal errors, as looks in a row have measurements in
common (of one alone it is 0.98 and 2.02); those with rho 0.9 have 0.92 and 3.16."""

COSINE_VARIANCE = 1.68
"""Of one difference's rise, see noise.MeasurementNoise; found alike, with 1.82 for rho 0.9."""

REDUNDANCY = 1.5
"""Of the three statistics, which are of the same measurements: of rho 0.5 they tell two thirds of
what they would if they were independent. Found in the same draws."""

GAIN_RANGE = 0.01, 0.99
"""Of the gains of filters: beyond them there is nothing to tell."""

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
"""The same of white acceleration alone; of smooth motion it is 0, as all point the same way."""

_KINDS = np.repeat([[3, WANDERING], [6, 0.0]], len(MOTION_SHARES), axis=0).T[..., None]
_MOTION = np.tile(MOTION_SHARES, 2)[:, None]
_LOG_GROWTHS = [
    np.log((1 - _MOTION) * _covariances(apart)[0] / _NEIGHBORS[0] + _MOTION * apart ** _KINDS[0])
    for apart in (2, 5)
]
_MIXED_RISES = (1 - _MOTION) * RISES + _MOTION * _KINDS[1]
"""Rises of errors and motion together, by the share of motion: interpolated between theirs."""


def weigh(looks: Floats, growths: Floats, count: Floats, rise: Floats) -> Floats:
    """Probabilities of RHO, (C, RHO), of C colors.

    What is not proven counts as white: lasting errors have none where white ones are likelier.

    :param looks: (C,) how many there were.
    :param growths: (C, 2) mean log of the squared differences at two and at five frames, less that
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


def passed_on(gain: Floats) -> Floats:
    """Variance of an alpha-beta filter's position, over that with white errors, (K, RHO).

    What filters make of white errors has an autocorrelation r_k that, from k = 2 on, follows their
    own difference equation, so that the sum of rho^|k| r_k, the variance with errors that last, is
    a fraction. Alpha and beta are of the steady state, see process_noise.

    :param gain: (K,) alpha.
    """
    alpha = gain.clip(*GAIN_RANGE)[:, None]
    x = np.sqrt(1 - alpha)
    y = x + 1 / x
    beta = x * (3 * y - np.sqrt(3 * (y * y + 8)))
    one, two = 2 - alpha - beta, alpha - 1
    r0 = (2 * alpha**2 + beta * (2 - 3 * alpha)) / (alpha * (4 - 2 * alpha - beta))
    r1 = (one * r0 + alpha * (beta - alpha)) / (1 - two)
    return np.asarray(2 * (1 + RHO * (r1 / r0 - one)) / (1 - RHO * (one + two * RHO)) - 1)
