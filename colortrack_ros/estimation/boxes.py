"""Areas of boxes: left, top, right, bottom [px], the first and last column and row, included."""

import numpy as np

from colortrack_ros.data import Floats


def intersections(one: Floats, other: Floats) -> Floats:
    """Return the areas of the intersections of boxes (N, 4) and (K, 4), (N, K) [px^2]."""
    low = np.maximum(one[:, None, :2], other[None, :, :2])
    high = np.minimum(one[:, None, 2:], other[None, :, 2:])
    return np.asarray(np.clip(high - low + 1, 0, None).prod(axis=2))


def extents(box: Floats) -> Floats:
    """Return the areas of boxes, (N,) [px^2]."""
    return np.asarray((box[:, 2:] - box[:, :2] + 1).prod(axis=1))


def overlaps(one: Floats, other: Floats) -> Floats:
    """Return the intersections over union of boxes (N, 4) and (K, 4), (N, K)."""
    common = intersections(one, other)
    return np.asarray(common / (extents(one)[:, None] + extents(other) - common))
