"""Boxes: first and last column and row of something, left, top, right, bottom [px]."""

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]

LEAVES = 2
"""A target that comes so near to the border and is not seen has left [px]. Half
and twice the value change nothing on PETS S3.MF1 (``benchmark/real_contours.py``)."""


def boxes(outlines: Floats) -> Floats:
    """Boxes of outlines (N, P, 2): left, top, right, bottom, (N, 4) [px]."""
    return np.concatenate([outlines.min(axis=1), outlines.max(axis=1)], axis=1)


def intersections(one: Floats, other: Floats) -> Floats:
    """Areas that boxes (N, 4) and (K, 4) have in common, (N, K) [px^2]."""
    low = np.maximum(one[:, None, :2], other[None, :, :2])
    high = np.minimum(one[:, None, 2:], other[None, :, 2:])
    return np.asarray(np.clip(high - low + 1, 0, None).prod(axis=2))


def extents(box: Floats) -> Floats:
    """Areas of boxes, (N,) [px^2]."""
    return np.asarray((box[:, 2:] - box[:, :2] + 1).prod(axis=1))


def overlaps(one: Floats, other: Floats) -> Floats:
    """Intersections over union of boxes (N, 4) and (K, 4), (N, K)."""
    common = intersections(one, other)
    return np.asarray(common / (extents(one)[:, None] + extents(other) - common))


def is_at_border(box: Floats, height: int, width: int) -> Bools:
    """Which boxes, (N, 4), come as near to the border of the picture as what leaves it, (N,)."""
    far = np.array([width, height]) - 1 - LEAVES
    return np.asarray((box[:, :2] <= LEAVES).any(axis=1) | (box[:, 2:] >= far).any(axis=1))
