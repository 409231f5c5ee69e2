"""What a blob that is cut or merged says about the object's center.

A track remembers how far its object reaches from the centroid to each side of its box. A blob
narrower than that is cut (an occluder, the edge of the picture), a wider one is merged with
another. Either way one of its two sides is still a side of the object, and gives its center.
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

EDGE_VARIANCE = 1.0
"""Of the place of a box's side [px^2]: a whole pixel, its threshold, and the learned reach."""

TOLERANCE = 2.0
TOLERANCE_SHARE = 0.05
"""A box is whole when its size differs by no more than this from the track's [px], [1]."""


def sides(rows: NDArray[np.void]) -> Floats:
    """Outer borders of the boxes.

    :param rows: (M,) of dtype DETECTION.
    :return: (M, 2, 2) [px]: low and high side, by axis (u, v).
    """
    low = np.stack([rows['box_u'], rows['box_v']], axis=1) - 0.5
    size = np.stack([rows['box_w'], rows['box_h']], axis=1)
    return np.stack([low, low + size], axis=1).astype(float)


def reach(rows: NDArray[np.void]) -> Floats:
    """How far the boxes reach from the centroid.

    :param rows: (M,) of dtype DETECTION.
    :return: (M, 2, 2) [px]: to the low and to the high side, by axis (u, v).
    """
    low, high = np.moveaxis(sides(rows), 1, 0)
    z = np.stack([rows['u'], rows['v']], axis=1)
    return np.stack([z - low, high - z], axis=1)


def difference(size: Floats, blob: Floats) -> Floats:
    """Size of the blob beyond the object's, 0 within the tolerance.

    :param size: (K, 2) of the object [px].
    :param blob: (K, 2) of the blob [px].
    :return: (K, 2) [px], negative for a blob that is cut.
    """
    excess = blob - size
    slack = np.abs(excess) - TOLERANCE - TOLERANCE_SHARE * size
    return np.where(slack > 0, excess, 0.0)


def measure(
    z: Floats, R: Floats, box: Floats, extent: Floats, expected: Floats, variance: Floats
) -> tuple[Floats, Floats]:
    """The measurement of an object's center that a blob gives, and its covariance.

    For each axis the better of two. The centroid may be off by half the difference of sizes. The
    sides give the center twice, low side + reach and high side - reach; how well each agrees with
    the prediction weighs them (a mixture of two Gaussians, replaced by its mean and variance).

    :param z: (K, 2) centroid [px].
    :param R: (K, 2, 2) its covariance [px^2].
    :param box: (K, 2, 2) sides of the blob's box [px], see sides().
    :param extent: (K, 2, 2) reach of the object [px], see reach().
    :param expected: (K, 2) predicted center [px].
    :param variance: (K, 2) of the prediction [px^2].
    :return: (K, 2) and (K, 2, 2).
    """
    excess = difference(extent.sum(axis=1), box[:, 1] - box[:, 0])
    centers = np.stack([box[:, 0] + extent[:, 0], box[:, 1] - extent[:, 1]])
    d2 = (centers - expected) ** 2 / (variance + EDGE_VARIANCE)
    low = 1 / (1 + np.exp(np.clip((d2[0] - d2[1]) / 2, -50, 50)))
    by_side = low * centers[0] + (1 - low) * centers[1]
    side_variance = EDGE_VARIANCE + low * (1 - low) * excess**2
    axis = np.arange(2)
    centroid_variance = R[:, axis, axis] + excess**2 / 4
    better = (excess != 0) & (side_variance < centroid_variance)
    covariance = np.where((better.any(axis=1))[:, None, None], 0.0, R)
    covariance[:, axis, axis] = np.where(better, side_variance, centroid_variance)
    return np.where(better, by_side, z), covariance


def learn(extent: Floats, blob: Floats, dt: float) -> Floats:
    """The reach after one more blob.

    It follows a whole blob, and one that grows as an object entering the picture does; it shrinks
    slowly, since it is much more often covered than smaller, and does not follow a merged blob.

    :param extent: (K, 2, 2) of the object [px].
    :param blob: (K, 2, 2) of the blob [px].
    :param dt: since the last frame [s].
    :return: (K, 2, 2) [px].
    """
    size, blob_size = extent.sum(axis=1), blob.sum(axis=1)
    excess = difference(size, blob_size)
    slow = 1 - np.exp(-dt / 2.0)
    growing = (excess > 0) & (blob_size < 1.25 * size + 4 * TOLERANCE)
    rate = np.where(excess == 0, 0.2, np.where(growing, 1.0, slow))
    return extent + rate[:, None] * (blob - extent)
