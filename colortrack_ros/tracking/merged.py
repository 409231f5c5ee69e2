"""Merged blobs: which side of the box belongs to which object."""

import numpy as np
from scipy.special import ndtr

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.tracking.measurements import Measurements

EDGE_VARIANCE = 1.0
"""Variance of the position of a box's side [px^2]: 1/12 for whole pixels, plus the errors of its
threshold and of the learned extent. Assumed."""

LEAN_VARIANCE = 0.04
"""Variance of the correlation of u and v in a blob of two: a standard deviation of 0.2. Assumed."""


def sides_of_several(
    blobs: Measurements, blob: Indices, center: Floats, expected: Floats, variance: Floats
) -> Floats:
    """Return the probabilities, (3, K, 2), of the possible centers of objects that share blobs.

    :param blobs: of the frame.
    :param blob: (K,) index of the shared blob; each occurs at least twice.
    :param center: (3, K, 2) see centers.centers() [px].
    :param expected: (K, 2) predicted centers [px].
    :param variance: (K, 2) of the predictions [px^2].
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
    """Return the probabilities of the centers, (3, K, 2), by the predicted order on each axis.

    With the probability that the predictions are in the right order, the lowest object owns the low
    side, and the highest the high side. Those in between can be anywhere.
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
    """Return the log-likelihood that two objects lie along the main diagonal of their blob, (P,).

    The box is the same for both diagonals. If the detector derives the covariance of the centroid
    from second moments, its correlation shows the diagonal: two discs of radius r, (a, b) apart,
    have a b / sqrt((r^2 + a^2) (r^2 + b^2)) on the main one, and minus that on the other.

    :param one, other: (3, P, 2) their centers.
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
    """Return the probability that the first of two objects on a blob owns the low side, (P, 2).

    The first is low or high in u, low or high in v, and the second is opposite. Each of the four
    arrangements is weighted by its agreement with both predictions and with the correlation of the
    blob.
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
