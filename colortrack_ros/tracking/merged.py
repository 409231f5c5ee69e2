"""Which side of a merged blob is whose."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from colortrack_ros.tracking.measurements import Measurements

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

EDGE_VARIANCE = 1.0
"""Of the place of a box's side [px^2]: that of a whole pixel, 1/12, and of its threshold and
the learned extent. Assumed."""

LEAN_VARIANCE = 0.04
"""Of the correlation of u and v in a blob of two: a standard deviation of 0.2. Assumed."""


def sides_of_several(
    blobs: Measurements, blob: Indices, center: Floats, expected: Floats, variance: Floats
) -> Floats:
    """Probabilities of the three centers of objects that share blobs.

    :param blobs: of the frame.
    :param blob: (K,) which of them; each at least twice.
    :param center: (3, K, 2) see centers.centers() [px].
    :param expected: (K, 2) predicted centers [px].
    :param variance: (K, 2) of the predictions [px^2].
    :return: (3, K, 2).
    """
    weight = _by_order(blob, expected, variance)
    order = np.argsort(blob, kind='stable')
    _, start, count = np.unique(blob[order], return_index=True, return_counts=True)
    one, other = order[start[count == 2]], order[start[count == 2] + 1]
    lean = _lean(blobs, blob[one], center[:, one], center[:, other])
    low = _by_place(center, expected, variance, one, other, lean)
    weight[:, one] = low, np.zeros_like(low), 1 - low
    weight[:, other] = 1 - low, np.zeros_like(low), low
    return weight


def _by_order(blob: Indices, expected: Floats, variance: Floats) -> Floats:
    """By each axis the object predicted lowest owns the low side, the highest the high side.

    That with the probability that the prediction has them in the right order. The objects between
    can be anywhere.
    """
    weight = np.full((3, *expected.shape), 1 / 3)
    for axis in range(2):
        order = np.lexsort((expected[:, axis], blob))
        x, s2, b = expected[order, axis], variance[order, axis], blob[order]
        first = np.append(True, b[1:] != b[:-1])
        last = np.append(b[1:] != b[:-1], True)
        right = ndtr(np.diff(x) / np.sqrt(s2[1:] + s2[:-1]))
        low = np.where(first, np.append(right, 0.5), 1 - np.append(0.5, right))
        outer = order[first | last]
        low = low[first | last]
        weight[:, outer, axis] = np.stack([low, np.zeros_like(low), 1 - low])
    return weight


def _lean(blobs: Measurements, blob: Indices, one: Floats, other: Floats) -> Floats:
    """Log-likelihood that two objects lie along the main diagonal of their blob, not the other.

    Both fill the same box. But the covariance of the centroid, if the detector made it from the
    blob's second moments, shows how the blob leans: two discs of radius r, (a, b) apart, have the
    correlation a b / sqrt((r^2 + a^2) (r^2 + b^2)), or minus that.

    :param one, other: (3, P, 2) their centers.
    :return: (P,).
    """
    R = blobs.R[blob]
    correlation = R[:, 0, 1] / np.sqrt(R[:, 0, 0] * R[:, 1, 1])
    apart = np.abs(one[0] - other[2])
    radius = np.maximum(blobs.size[blob] - apart, 1.0) / 2
    expected = (apart / np.hypot(radius, apart)).prod(axis=1)
    return np.asarray(correlation * expected / LEAN_VARIANCE)


def _by_place(
    center: Floats, expected: Floats, variance: Floats, one: Indices, other: Indices, lean: Floats
) -> Floats:
    """Of two objects on a blob the probability that the first owns the low side, (P, 2).

    The first is low or high by u, low or high by v, and the second opposite: four places, each as
    likely as it agrees with both predictions and with how the blob leans.
    """
    d2 = (center - expected) ** 2 / (variance + EDGE_VARIANCE)
    low, high = -(d2[0, one] + d2[2, other]) / 2, -(d2[2, one] + d2[0, other]) / 2
    place = np.array(
        [
            [low[:, 0] + low[:, 1] + lean, low[:, 0] + high[:, 1] - lean],
            [high[:, 0] + low[:, 1] - lean, high[:, 0] + high[:, 1] + lean],
        ]
    )
    place = np.exp(place - place.max(axis=(0, 1)))
    place /= place.sum(axis=(0, 1))
    return np.stack([place[0].sum(axis=0), place[:, 0].sum(axis=0)], axis=1)
