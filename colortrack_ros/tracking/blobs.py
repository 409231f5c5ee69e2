"""What a blob that is cut, merged or broken says about the centers of objects.

A track remembers how far its object reaches from the centroid to each side of its box. A blob
narrower than that is cut (an occluder, the edge of the picture), a wider one is merged with
another. Either way one of its two sides is still a side of the object, and gives its center.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from colortrack_ros.tracking.intake import Blobs

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

EDGE_VARIANCE = 1.0
"""Of the place of a box's side [px^2]: a whole pixel, its threshold, and the learned reach."""

TOLERANCE = 2.0
TOLERANCE_SHARE = 0.05
"""A box is whole when its size differs by no more than this from the track's [px], [1]."""

FOLLOWING = 0.2
"""Share of a whole blob's size in the learned size."""

GROWING, SHRINKING = 0.3, 2.0
"""Time constants of the learned size towards a suddenly larger and towards a smaller blob [s]."""


def slack(size: Floats) -> Floats:
    """How much the size of a whole blob may differ from the object's size [px]."""
    return TOLERANCE + TOLERANCE_SHARE * size


def difference(size: Floats, blob: Floats) -> Floats:
    """Size of the blob beyond the object's, 0 within the tolerance.

    :param size: (K, 2) of the object [px].
    :param blob: (K, 2) of the blob [px].
    :return: (K, 2) [px], negative for a blob that is cut.
    """
    excess = blob - size
    return np.where(np.abs(excess) > slack(size), excess, 0.0)


def nearer_side(box: Floats, extent: Floats, expected: Floats, variance: Floats) -> Floats:
    """Probability that the low side is the object's own, of one object alone on its blob.

    :param box: (K, 2, 2) sides of the blob [px].
    :param extent: (K, 2, 2) reach of the object [px].
    :param expected: (K, 2) predicted center [px].
    :param variance: (K, 2) of the prediction [px^2].
    :return: (K, 2), by axis.
    """
    low, high = box[:, 0] + extent[:, 0], box[:, 1] - extent[:, 1]
    d2 = ((low - expected) ** 2 - (high - expected) ** 2) / (variance + EDGE_VARIANCE)
    return 1 / (1 + np.exp(np.clip(d2 / 2, -50, 50)))


def order_of_sides(blob: Indices, expected: Floats, variance: Floats) -> Floats:
    """Probability that the low side is the object's own, of several objects on one blob.

    By each axis the object predicted lowest owns the low side, the one predicted highest the high
    side, with the probability that the prediction has them in the right order; the objects between
    own none, and get one half.

    :param blob: (K,) which objects share a blob.
    :param expected: (K, 2) predicted centers [px].
    :param variance: (K, 2) of the predictions [px^2].
    :return: (K, 2), by axis.
    """
    low = np.full(expected.shape, 0.5)
    for axis in range(2):
        order = np.lexsort((expected[:, axis], blob))
        x, s2, b = expected[order, axis], variance[order, axis], blob[order]
        same = b[1:] == b[:-1]
        right = ndtr(np.diff(x) / np.sqrt(s2[1:] + s2[:-1]))
        lowest = np.append(True, ~same)
        highest = np.append(~same, True)
        of_sorted = np.full(len(b), 0.5)
        of_sorted[highest] = 1 - np.append(0.5, right)[highest]
        of_sorted[lowest] = np.append(right, 0.5)[lowest]
        low[order, axis] = of_sorted
    return low


def measure(z: Floats, R: Floats, box: Floats, extent: Floats, low: Floats) -> tuple:
    """The measurement of an object's center that a blob gives, and its covariance.

    For each axis the better of two. The centroid may be off by half the difference of sizes. The
    sides give the center twice, low side + reach and high side - reach: two Gaussians, of weights
    low and 1 - low, replaced by their common mean and variance.

    :param z: (K, 2) centroid [px].
    :param R: (K, 2, 2) its covariance [px^2].
    :param box: (K, 2, 2) sides of the blob [px].
    :param extent: (K, 2, 2) reach of the object [px].
    :param low: (K, 2) probability that the low side is the object's own.
    :return: (K, 2) and (K, 2, 2).
    """
    size = extent.sum(axis=1)
    excess = box[:, 1] - box[:, 0] - size
    by_side = low * (box[:, 0] + extent[:, 0]) + (1 - low) * (box[:, 1] - extent[:, 1])
    side_variance = EDGE_VARIANCE + low * (1 - low) * excess**2
    axis = np.arange(2)
    centroid_variance = R[:, axis, axis] + excess**2 / 4
    better = (side_variance < centroid_variance) & (size > 0)
    covariance = np.where(better.any(axis=1)[:, None, None], 0.0, R)
    covariance[:, axis, axis] = np.where(better, side_variance, centroid_variance)
    return np.where(better, by_side, z), covariance


def join(blobs: Blobs, piece: Indices, whole: Indices) -> Blobs:
    """Add pieces of broken blobs to the blobs that their tracks have taken.

    What is missing between them draws the centroid aside, so the middle of the box replaces it.

    :param blobs: (M,).
    :param piece: (K,) indices of the pieces.
    :param whole: (K,) index of the blob that each belongs to.
    :return: (M,) with the joint boxes in the places of the wholes.
    """
    z, R, box = blobs.z.copy(), blobs.R.copy(), blobs.box.copy()
    np.minimum.at(box[:, 0], whole, box[piece, 0])
    np.maximum.at(box[:, 1], whole, box[piece, 1])
    z[whole] = box[whole].mean(axis=1)
    R[whole] = EDGE_VARIANCE * np.eye(2)
    return Blobs(blobs.rows, z, R, box)


def learn(extent: Floats, z: Floats, box: Floats, expected: Floats, dt: float) -> Floats:
    """The reach after one more blob that the object has for itself.

    It follows a whole blob, and one that grows as an object coming into view does. A sudden growth
    may be that of a merged blob, and is followed more slowly. Towards a smaller blob it goes
    slowest, and only if the centroid is nearer to the prediction than what either side says: else
    the object is not smaller but cut.

    :param extent: (K, 2, 2) of the object [px].
    :param z: (K, 2) centroid [px].
    :param box: (K, 2, 2) sides of the blob [px].
    :param expected: (K, 2) predicted center [px].
    :param dt: since the last frame [s].
    :return: (K, 2, 2) [px].
    """
    reach = np.stack([z - box[:, 0], box[:, 1] - z], axis=1)
    size, blob = extent.sum(axis=1), reach.sum(axis=1)
    excess = difference(size, blob)
    whole = excess == 0
    step = 4 * TOLERANCE + 0.5 * size.max(axis=1, initial=0.0)
    growing = (excess > 0) & (excess < step[:, None]).all(axis=1)[:, None]
    centers = np.stack([box[:, 0] + extent[:, 0], box[:, 1] - extent[:, 1]])
    cut = np.abs(z - expected) > np.abs(centers - expected).min(axis=0)
    slow = np.where(excess > 0, 1 - np.exp(-dt / GROWING), ~cut * (1 - np.exp(-dt / SHRINKING)))
    rate = np.where(whole, FOLLOWING, np.where(growing, 1.0, slow))
    return extent + rate[:, None] * (reach - extent)
