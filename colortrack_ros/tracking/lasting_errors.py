"""Measurement errors that last longer than a frame, and how much of them differences show.

Errors with the autocorrelation rho^k after k frames (shading that moves with the object, boxes
regressed by a network) have a part in common in neighboring measurements, which cancels in their
differences. Third differences of measurements two and five frames apart show more of it, at ratios
that motion does not have: their squares grow with the cube of the spacing for white acceleration,
and with its sixth power for smooth motion.
"""

import numpy as np
from scipy.special import hyp2f1

from colortrack_ros.data import Floats

RHO = np.array([0.0, 0.3, 0.5, 0.7, 0.8, 0.9])
"""Autocorrelations from frame to frame that are compared. Higher ones cannot be told from a random
walk of the object during the second or so in which it moves straight."""

MOTION_SHARES = np.append(np.geomspace(0.95, 1e-5, 30), 0.0)
"""Shares of motion in the squared differences of neighbors that are compared; the rest is
measurement error. Smooth motion with a share of 1e-5 there makes up a sixth of the square five
frames apart."""

WHITE_PRIOR = 0.92
"""Prior probability of white errors. Assumed: lasting errors have to be proven. With 0.95 the
ellipses under errors with rho 0.3 to 0.9 cover 3 to 14 % less in the first three seconds."""

LOG_VARIANCES = np.array([1.18, 3.47])
"""Variances, per look, of the mean log square of differences at two and at five frames, minus that
of neighbors. Found by drawing long series of white normal errors, as successive looks share
measurements (a single look has 0.98 and 2.02); errors with rho 0.9 have 0.92 and 3.16."""

COSINE_VARIANCE = 1.68
"""Variance of the rise of a single difference, see RISES. Found likewise; rho 0.9 has 1.82."""

REDUNDANCY = 1.5
"""Redundancy of the three statistics, which use the same measurements: on rho 0.5 they carry two
thirds of the information of independent ones. Found in the same draws."""

GAIN_RANGE = 0.01, 0.99
"""Range of filter gains; beyond it the ratio hardly changes."""

BINOMIAL = np.array([1.0, -3.0, 3.0, -1.0])
"""Weights of a third difference."""


def mean_cosine(correlation: Floats) -> Floats:
    """Return the mean cosine of the angle between two normal vectors in the plane.

    :param correlation: of the two, by axis.
    """
    return np.asarray(np.pi / 4 * correlation * hyp2f1(0.5, 0.5, 2.0, correlation**2))


def _covariances(apart: int) -> Floats:
    """Return the covariances of third differences with those 0, 1 and 2 frames before, (3, RHO).

    They are relative to the variance of the errors.

    :param apart: spacing of the measurements [frames].
    """
    at = apart * np.arange(4)
    lag = np.abs(at[:, None] - at - np.arange(3)[:, None, None])
    return np.einsum('i,j,kijr->kr', BINOMIAL, BINOMIAL, RHO ** lag[..., None])


_NEIGHBORS = _covariances(1)
SHOWN_BY_NEIGHBORS = _NEIGHBORS[0] / _NEIGHBORS[0, 0]
"""Share of the error variance that differences of neighbors show, by RHO."""

RISES = np.diff(mean_cosine(_NEIGHBORS[1:] / _NEIGHBORS[0]), axis=0)[0]
"""Rises of errors alone, by RHO: the mean cosine between third differences two frames apart, minus
that one frame apart."""

WANDERING = float(np.diff(mean_cosine(np.array([-1 / 3, -1 / 6])))[0])
"""Rise of white acceleration alone. That of smooth motion is 0, as all differences are parallel."""

_KINDS = np.repeat([[3, WANDERING], [6, 0.0]], len(MOTION_SHARES), axis=0).T[..., None]
_MOTION = np.tile(MOTION_SHARES, 2)[:, None]
_LOG_GROWTHS = [
    np.log((1 - _MOTION) * _covariances(apart)[0] / _NEIGHBORS[0] + _MOTION * apart ** _KINDS[0])
    for apart in (2, 5)
]
_MIXED_RISES = (1 - _MOTION) * RISES + _MOTION * _KINDS[1]
"""Rises of errors and motion together, interpolated by the share of motion."""


def weigh(looks: Floats, growths: Floats, count: Floats, rise: Floats) -> Floats:
    """Return the probabilities of RHO, (C, RHO), for C colors.

    What is not proven counts as white: lasting errors get 0 where white ones are more likely.

    :param looks: (C,) number of looks.
    :param growths: (C, 2) mean log square of differences at two and at five frames, minus that of
        neighbors.
    :param count: (C,) number of differences.
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
    """Return the position variance of alpha-beta filters over that under white errors, (K, RHO).

    From k = 2 on, the autocorrelation r_k of the filter's response to white errors follows the
    filter's own difference equation. The variance under lasting errors, the sum of rho^|k| r_k, is
    therefore a rational function. Alpha and beta are those of the steady state, see process_noise.

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
