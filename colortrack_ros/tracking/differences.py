"""Third differences of the last measurements of tracks: the evidence on measurement noise."""

import math

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.tracking.lasting_errors import mean_cosine
from colortrack_ros.tracking.lasting_errors import RISES
from colortrack_ros.tracking.lasting_errors import WANDERING
from colortrack_ros.tracking.recent import EVERY
from colortrack_ros.tracking.recent import GIVEN
from colortrack_ros.tracking.recent import MANEUVERED
from colortrack_ros.tracking.recent import UNMEASURED
from colortrack_ros.tracking.recent import WHOLE
from colortrack_ros.tracking.recent import Z

DIFFERENCES, LOG, RISE, GIVEN_LOG, LEAN, LOOKS, TWO_APART, FIVE_APART, STAIRS, RISERS = range(10)
SUMS = 10
"""Sums that make up the evidence: the number of differences; over these, the log squares, the
differences of cosines, the log variances given, and half the log ratios of the squares by axis; the
number of looks; over these, the excess of the log squares of differences two and five frames apart;
the number of single steps of an otherwise constant coordinate, and their squares."""

COMPARED = 6
"""Measurements spanned by a difference together with the two before it, with which it is
compared."""

TOGETHER = EVERY + COMPARED - 1
"""Measurements processed together: those new since the last look, and those that their differences
reach back to."""

FIVES = 5 * np.arange(4)
"""Measurements five frames apart; those in between may be missing."""

ALL_FOURS = np.array(
    [i + apart * np.arange(4) for apart in (1, 2) for i in range(TOGETHER - 3 * apart)] + [FIVES]
)
"""Quadruples of measurements whose third differences are taken."""

ONE_APART, OTHERS_APART = slice(0, TOGETHER - 3), (slice(TOGETHER - 3, -1), slice(-1, None))
"""Quadruples of successive measurements, and of measurements two and five frames apart."""

CORRELATIONS = np.linspace(-1, 1, 401)
COSINES = mean_cosine(CORRELATIONS)
"""Table of mean_cosine(), as the hypergeometric function is slow. Interpolation is off by 1e-4."""

LEAST_SQUARE = 1e-4
"""Least square of a normalized difference, for objects that are exactly at rest: a hundredth of a
standard deviation, as process_noise.LEAST_NOISE."""


SURE_TURN = 0.6
"""Probability of a maneuver above which a look says nothing about lasting errors. Assumed: with 0.9
a bouncing crowd appears to have lasting errors in one run of ten; with 0.3, errors with rho 0.3 are
found later because they pass for turns."""


def tell(measured: Floats, stamps: Floats, in_a_row: Indices, lean: Floats) -> Floats:
    """Return the evidence from the last frames of tracks, (K, SUMS).

    :param measured: (K, RING, columns) see recent, the newest first.
    :param stamps: (RING,) [s].
    :param in_a_row: (K,) number of measurements in a row.
    :param lean: (K,) log ratio of the noise by axis to its mean, as learned so far.
    """
    told = _tell_in_a_row(measured, stamps, in_a_row, lean)
    fewer = (in_a_row < TOGETHER).nonzero()[0]
    if len(fewer):
        count = np.count_nonzero(measured[fewer, :, WHOLE], axis=1)
        wholly = np.count_nonzero(measured[fewer, :, UNMEASURED], axis=1) <= count
        # Next to a merged or cut measurement the others are no clean sample either.
        missed = fewer[wholly & (count >= COMPARED) & (count > in_a_row[fewer])]
        if len(missed):
            told[missed] = tell_of_gaps(measured[missed], stamps, lean[missed])
    return told


def _tell_in_a_row(measured: Floats, stamps: Floats, in_a_row: Indices, lean: Floats) -> Floats:
    """Return the evidence from up to TOGETHER measurements in a row; see tell()."""
    z = measured[..., Z]
    given = np.maximum(measured[..., GIVEN], 1e-12)
    variance = given * np.exp(lean[:, None] * [1, -1])[:, None]
    W = third_differences(stamps, ALL_FOURS)
    one = _normalized(z, variance, W[ONE_APART])
    two, five = (_normalized(z, variance, W[rows]) for rows in OTHERS_APART)
    length, long, longest = (_log_half_square(D) for D in (one, two, five))
    each = _of_each(one, length, given[:, :TOGETHER], lean)
    counted = in_a_row[:, None] >= np.arange(COMPARED, COMPARED + EVERY)
    each = (each * counted).sum(axis=2)
    # A turn looks like lasting errors, and is in more of the long differences.
    steady = measured[..., MANEUVERED].max(axis=1) < SURE_TURN
    level, full = length[:, :EVERY].mean(axis=1), (in_a_row >= TOGETHER) & steady
    full &= measured[:, FIVES, WHOLE].all(axis=1)
    looks = np.array([np.ones_like(level), long.mean(axis=1) - level, longest.mean(axis=1) - level])
    step = (z[:, : EVERY + 2] - z[:, 1 : EVERY + 3]) ** 2
    step[:, 1:-1] *= (step[:, :-2] == 0) & (step[:, 2:] == 0)
    riser = step[:, 1:-1].sum(axis=2) * counted
    stairs = np.array([np.count_nonzero(riser, axis=1), riser.sum(axis=1)])
    return np.concatenate([each, looks * full, stairs]).T


def _of_each(one: Floats, length: Floats, given: Floats, lean: Floats) -> Floats:
    """Return what each of the newest differences adds to the first five sums, (5, K, EVERY).

    :param one: (K, EVERY + 2, 2) normalized differences.
    :param length: (K, EVERY + 2) of these, see _log_half_square().
    :param given: (K, TOGETHER, 2) variances of the measurements.
    :param lean: (K,) see tell().
    """
    logs = np.log(np.maximum(one[:, :EVERY] ** 2, LEAST_SQUARE))
    ratio = (logs[..., 0] - logs[..., 1]) / 2 + lean[:, None]
    direction = one / np.exp(length / 2)[..., None] / math.sqrt(2)
    after_one = (direction[:, :EVERY] * direction[:, 1 : EVERY + 1]).sum(axis=2)
    after_two = (direction[:, :EVERY] * direction[:, 2 : EVERY + 2]).sum(axis=2)
    usual = np.log(given[:, :EVERY].mean(axis=2))
    length = length[:, :EVERY]
    return np.array([np.ones_like(length), length, after_two - after_one, usual, ratio])


def tell_of_gaps(measured: Floats, stamps: Floats, lean: Floats) -> Floats:
    """Return the evidence from the last measurements of tracks with missed detections; see tell().

    The cosines of noise and of motion depend on the times between measurements, see _usual_rises().
    Each rise is mapped to that of evenly spaced measurements with the same share of motion, and
    weighted by how well noise and motion are told apart, as in a weighted regression.
    """
    known = measured[..., WHOLE] > 0
    order = np.argsort(~known, axis=1, kind='stable')[:, :TOGETHER]
    some = np.take_along_axis(measured, order[..., None], axis=1)
    z, t = some[..., Z], stamps[order]
    given = np.maximum(some[..., GIVEN], 1e-12)
    variance = given * np.exp(lean[:, None] * [1, -1])[:, None]
    W = third_differences(t, ALL_FOURS[ONE_APART])
    one = _normalized(z, variance, W)
    each = _of_each(one, _log_half_square(one), given, lean)
    of_noise, of_motion = _usual_rises(W, variance.mean(axis=2), t)
    clear = (of_noise - of_motion) / (RISES[0] - WANDERING)
    weight = clear**2
    rise = weight * WANDERING + clear * (each[RISE] - of_motion)
    each *= weight
    each[RISE] = rise
    new = order[:, :EVERY] < EVERY
    new &= np.count_nonzero(known, axis=1)[:, None] >= np.arange(COMPARED, COMPARED + EVERY)
    told = np.zeros((len(measured), SUMS))
    told[:, : len(each)] = np.where(new, each, 0.0).sum(axis=2).T
    return told


def _usual_rises(W: Floats, variance: Floats, t: Floats) -> tuple[Floats, Floats]:
    """Return the rises, (K, EVERY), of noise alone, and of white acceleration alone.

    Under white acceleration, positions at s < t have the covariance s^2 (3 t - s) / 6. The initial
    position and velocity cancel in third differences.

    :param W: (K, EVERY + 2, TOGETHER) weights; variance: (K, TOGETHER) of the measurements.
    :param t: (K, TOGETHER) their stamps [s].
    """
    s = t - t.min(axis=1, keepdims=True)
    early, late = np.minimum(s[:, :, None], s[:, None]), np.maximum(s[:, :, None], s[:, None])
    of_motion = W @ (early * early * (3 * late - early)) @ W.swapaxes(1, 2)
    of_noise = (W * variance[:, None]) @ W.swapaxes(1, 2)
    return rise_of(of_noise), rise_of(of_motion)


def rise_of(covariance: Floats) -> Floats:
    """Return the mean cosine between normal vectors two places apart, minus that one place apart.

    :param covariance: (..., D, D) of the vectors, by axis.
    :return: (..., D - 2).
    """
    i = np.arange(covariance.shape[-1] - 2)
    variance = covariance[..., np.arange(len(i) + 2), np.arange(len(i) + 2)]
    one, two = (
        covariance[..., i, i + apart] / np.sqrt(variance[..., i] * variance[..., i + apart])
        for apart in (1, 2)
    )
    return np.interp(two, CORRELATIONS, COSINES) - np.interp(one, CORRELATIONS, COSINES)


def _normalized(z: Floats, variance: Floats, W: Floats) -> Floats:
    """Return differences of measurements over their standard deviations by axis, (K, D, 2).

    :param z, variance: (K, RING, 2).
    :param W: (D, RING) weights.
    """
    return np.asarray((W @ z) / np.sqrt(np.square(W) @ variance))


def _log_half_square(difference: Floats) -> Floats:
    """Return logs of half the squared length, (K, D), of normalized differences, (K, D, 2)."""
    square = difference[..., 0] ** 2 + difference[..., 1] ** 2
    return np.log(np.maximum(square, LEAST_SQUARE) / 2)


def third_differences(t: Floats, four: Indices) -> Floats:
    """Return the weights of measurements in third divided differences, (..., D, R).

    :param t: (..., R) stamps of the measurements, the newest first [s].
    :param four: (D, 4) measurements of each difference.
    """
    unit = np.maximum(t[..., 0] - t[..., 1], 1e-6)[..., None, None, None]
    times = t[..., four]
    between = (times[..., :, None] - times[..., None, :]) / unit
    between[..., range(4), range(4)] = 1.0
    W = np.zeros((*t.shape[:-1], len(four), t.shape[-1]))
    with np.errstate(divide='ignore'):
        W[..., np.arange(len(four))[:, None], four] = 1 / between.prod(axis=-1)
    return W
