"""What a blob that is cut, merged or broken says about the centers of objects.

A track remembers how far its object reaches from the centroid to each side of its box. A blob
narrower than that is cut (an occluder, the edge of the picture), a wider one is merged with
another. Either way one of its two sides is still a side of the object, and gives its center.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.tracking.measurements import Measurements

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.intp]

# Constants marked "assumed" were set by hand; benchmark/ablation.py --constants extents.NAME shows
# what IDF1 becomes with half and twice the value.

EDGE_VARIANCE = 1.0
"""Of the place of a box's side [px^2]: that of a whole pixel, 1/12, and of its threshold and
the learned extent. Assumed."""

TOLERANCE = 2.0
TOLERANCE_SHARE = 0.05
"""A box is whole when its size differs by no more than this from the track's [px], [1]: a pixel on
each side, and assumed changes of the object by a twentieth."""

OTHER_SIZE = 0.02
"""Probability that a blob has another size than its object. Assumed: one in 50, as for colors."""

LASTING = 4.0
"""Number of frames in which the doubt about the side makes the same error: variances are multiplied
by it, as the filter takes errors of successive frames to be independent. Assumed."""

FOLLOWING_SHARE = 0.2
"""Share of a whole blob's size in the learned size, a memory of five frames. Assumed."""

GROWING, SHRINKING = 0.3, 2.0
"""Time constants of the learned size [s]: towards a blob that is suddenly larger, or smaller and
stays so; and towards one that is smaller and does not. Assumed."""


def total(extent: Floats) -> Floats:
    """(K, 2) sizes of extents, (K, 2, 2): from the low to the high side [px]."""
    return np.asarray(extent[:, 0] + extent[:, 1])


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


def log_fit(size: Floats, blob: Floats, alike: float) -> Floats:
    """Log-likelihood ratio of blobs' sizes: of these objects, against of any other.

    An object's own blob differs by a slack, one in 50 by anything. Others are alike, or up to twice
    as large.

    :param size: (K, 2) of the object [px].
    :param blob: (K, 2) of the blob [px].
    :param alike: share of the others that have the size of an object.
    :return: (K,).
    """
    e = (blob - size) / slack(size)
    e *= e
    d2 = e[:, 0] + e[:, 1]
    return np.asarray(np.log(OTHER_SIZE + np.exp(most_fitting(size, alike) - d2 / 2)))


def most_fitting(size: Floats, alike: float) -> Floats:
    """Log-likelihood ratio, at least 0, of a blob of just that size, (K, 2); see log_fit()."""
    share = slack(size) / np.maximum(size, 1.0)
    broad = np.pi / 2 * (share[:, 0] * share[:, 1])
    return np.asarray(np.log(np.maximum((1 - OTHER_SIZE) / (alike + broad), 1.0)))


def count_alike(size: Floats, blob: Floats) -> int:
    """Number of blobs, (K, 2) [px], that have the size of any of the objects, (N, 2) [px]."""
    same = np.abs(blob[:, None] - size) <= slack(size)
    return int(np.count_nonzero((same[..., 0] & same[..., 1]).any(axis=1)))


def centers(z: Floats, box: Floats, extent: Floats) -> Floats:
    """Where the object's center is if the low side of the blob is its own, neither, or the high.

    :param z: (K, 2) centroid [px].
    :param box: (K, 2, 2) sides of the blob [px].
    :param extent: (K, 2, 2) extent of the object [px].
    :return: (3, K, 2) [px].
    """
    return np.stack([box[:, 0] + extent[:, 0], z, box[:, 1] - extent[:, 1]])


def centroid_variance(blobs: Measurements, blob: Indices, size: Floats) -> Floats:
    """Variance of centroids as the centers of objects, which may be off by half of what the sizes
    differ by beyond a pixel.

    :param blobs: of the frame.
    :param blob: (K,) which of them.
    :param size: (K, 2) of the object [px].
    :return: (K, 2) [px^2].
    """
    excess = np.maximum(np.abs(blobs.size[blob] - size) - 1, 0)
    return np.asarray(blobs.variance[blob] + LASTING * excess**2 / 4)


def sides_of_one(center: Floats, expected: Floats, variance: Floats) -> Floats:
    """Probabilities of the three centers of an object alone on its blob, by the prediction.

    :param center: (3, K, 2) see centers() [px].
    :param expected: (K, 2) predicted center [px].
    :param variance: (K, 2) of the prediction [px^2].
    :return: (3, K, 2).
    """
    d2 = (center - expected) ** 2 / (variance + EDGE_VARIANCE)
    weight = np.exp((d2.min(axis=0) - d2) / 2)
    return weight / weight.sum(axis=0)


def measure(
    blobs: Measurements,
    blob: Indices,
    size: Floats,
    partial: Bools,
    center: Floats,
    weight: Floats,
) -> tuple[Floats, Floats]:
    """The measurement of an object's center that a blob gives, and its covariance.

    For each axis the better of two: the centroid or the mixture of the three centers, replaced by
    its mean and variance. While an object comes into the picture, its size is as little known as
    how far it goes on outside.

    :param blobs: of the frame.
    :param blob: (K,) which of them.
    :param size: (K, 2) of the object [px], 0 where nothing is known of it.
    :param partial: (K, 2) the object has never been in sight wholly.
    :param center: (3, K, 2) see centers() [px].
    :param weight: (3, K, 2) probabilities of the three centers.
    :return: (K, 2) and (K, 2, 2).
    """
    R, of_centroid = blobs.R[blob], centroid_variance(blobs, blob, size)
    mean = (weight * center).sum(axis=0)
    variance = EDGE_VARIANCE + LASTING * (weight * (center - mean) ** 2).sum(axis=0)
    variance += np.where(partial, blobs.variance[blob], 0.0)
    better = (variance < of_centroid) & (size > 0)
    R[better.any(axis=1)] = 0.0
    R.reshape(-1, 4)[:, ::3] = np.where(better, variance, of_centroid)
    return np.where(better, mean, blobs.z[blob]), R


def join(blobs: Measurements, piece: Indices, whole: Indices) -> Measurements:
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
    joined = blobs.joined.copy()
    joined[whole] = True
    return replace(blobs, z=z, R=R, box=box, joined=joined)


def learn(
    extent: Floats,
    reach: Floats,
    excess: Floats,
    center: Floats,
    expected: Floats,
    last: Floats,
    way: Floats,
    dt: float,
) -> Floats:
    """The extent after one more blob that the object has for itself, of another size.

    A blob that grows as an object coming into view does, by no more than the way that it moves, is
    followed at once. A sudden growth may be that of a merged blob, and is followed more slowly.
    Towards a smaller blob it goes slowest, and only if the centroid is nearer to the prediction
    than what either side says, or the blob stays as it is: else the object is not smaller but cut.

    :param extent: (K, 2, 2) of the object [px].
    :param reach: (K, 2, 2) of the blob, see Measurements.reach() [px].
    :param excess: (K, 2) of its size, see difference() [px].
    :param center: (3, K, 2) see centers() [px].
    :param expected: (K, 2) predicted center [px].
    :param last: (K, 2) size of the last blob [px].
    :param way: (K,) that the object may have moved in this frame, at most [px].
    :param dt: since the last frame [s].
    :return: (K, 2, 2) [px].
    """
    blob = reach.sum(axis=1)
    small = excess < 4 * TOLERANCE + way[:, None]
    growing = (excess > 0) & (small[:, :1] & small[:, 1:])
    cut = np.abs(center - expected).argmin(axis=0) != 1
    steady = (np.abs(blob - last) < TOLERANCE).all(axis=1)[:, None]
    time = np.where((excess > 0) | steady, GROWING, np.where(cut, np.inf, SHRINKING))
    slow = 1 - np.exp(-dt / time)
    rate = np.where(excess == 0, FOLLOWING_SHARE, np.where(growing, 1.0, slow))
    return extent + rate[:, None] * (reach - extent)
