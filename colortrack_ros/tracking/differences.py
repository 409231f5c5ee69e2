"""Third differences of the last measurements of tracks: the evidence of how noisy they are."""

import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.tracking.recent import EVERY
from colortrack_ros.tracking.recent import GIVEN
from colortrack_ros.tracking.recent import RING
from colortrack_ros.tracking.recent import Z

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

DIFFERENCES, LOG, RISE, GIVEN_LOG, LEAN, LOOKS, TWO_APART, THREE_APART, STAIRS, RISERS = range(10)
SUMS = 10
"""What evidence sums up: differences; over these the logarithms of their squares, the differences
of their cosines, the logarithms of the variances given, and half of those of the ratio of the
squares by axis; looks; over these by how much squares of differences two and three frames apart
have larger logarithms; single changes of a coordinate that else stays, and their squares."""

LEAST_SQUARE = 1e-4
"""Of a normalized difference: of what stands still to the bit."""


def tell(measured: Floats, stamps: Floats, in_a_row: Indices, lean: Floats) -> Floats:
    """What the last frames tell of tracks, (K, 10).

    :param measured: (K, RING, columns) see recent, the newest first.
    :param stamps: (RING,) [s].
    :param in_a_row: (K,) how many measurements there were.
    :param lean: (K,) what is known of it.
    """
    z = measured[..., Z]
    given = np.maximum(measured[..., GIVEN], 1e-12)
    variance = given * np.exp(lean[:, None] * [1, -1])[:, None]
    one, two, three = (
        _normalized(z, variance, third_differences(stamps, range(RING - 3 * apart), apart))
        for apart in (1, 2, 3)
    )
    logs = np.log(np.maximum(one[:, :EVERY] ** 2, LEAST_SQUARE))
    ratio = (logs[..., 0] - logs[..., 1]) / 2 + lean[:, None]
    length, long, longest = (_log_half_square(D) for D in (one, two, three))
    direction = one / np.exp(length / 2)[..., None] / math.sqrt(2)
    after_one = (direction[:, :EVERY] * direction[:, 1 : EVERY + 1]).sum(axis=2)
    after_two = (direction[:, :EVERY] * direction[:, 2 : EVERY + 2]).sum(axis=2)
    length = length[:, :EVERY]
    usual = np.log(given[:, :EVERY].mean(axis=2))
    each = np.array([np.ones_like(length), length, after_two - after_one, usual, ratio])
    counted = in_a_row[:, None] >= np.arange(6, 6 + EVERY)
    each = (each * counted).sum(axis=2)
    level, full = length.mean(axis=1), in_a_row >= RING
    looks = np.array([np.ones_like(level), long.mean(axis=1) - level, longest.mean(axis=1) - level])
    step = (z[:, : EVERY + 2] - z[:, 1 : EVERY + 3]) ** 2
    step[:, 1:-1] *= (step[:, :-2] == 0) & (step[:, 2:] == 0)
    riser = step[:, 1:-1].sum(axis=2) * counted
    stairs = np.array([np.count_nonzero(riser, axis=1), riser.sum(axis=1)])
    return np.concatenate([each, looks * full, stairs]).T


def _normalized(z: Floats, variance: Floats, W: Floats) -> Floats:
    """Differences of measurements over their standard deviations by axis, (K, D, 2).

    :param z, variance: (K, RING, 2).
    :param W: (D, RING) weights.
    """
    return np.asarray((W @ z) / np.sqrt(np.square(W) @ variance))


def _log_half_square(difference: Floats) -> Floats:
    """Logarithms of half of the squared length, (K, D), of normalized differences, (K, D, 2)."""
    square = difference[..., 0] ** 2 + difference[..., 1] ** 2
    return np.log(np.maximum(square, LEAST_SQUARE) / 2)


def third_differences(t: Floats, first: range, apart: int) -> Floats:
    """Weights of RING measurements in third divided differences, (len(first), RING).

    :param t: (RING,) their stamps, the newest first [s].
    :param first: the newest measurement of each.
    :param apart: frames between two of the four.
    """
    four = np.array(first)[:, None] + apart * np.arange(4)
    between = (t[four][:, :, None] - t[four][:, None, :]) / max(t[0] - t[1], 1e-6)
    between[:, range(4), range(4)] = 1.0
    W = np.zeros((len(four), RING))
    with np.errstate(divide='ignore'):
        np.put_along_axis(W, four, 1 / between.prod(axis=2), axis=1)
    return W
