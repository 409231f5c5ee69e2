"""Boxes: left, top, right, bottom [px], the first and last column and row, included."""

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats

LEAVES = 2
"""An unseen target this close to the border has left the picture [px]. Assumed: half and twice the
value change nothing on PETS S3.MF1 (``benchmark/real_contours.py``)."""


def boxes(outlines: Floats) -> Floats:
    """Return the boxes, (N, 4) [px], of outlines, (N, P, 2)."""
    return np.concatenate([outlines.min(axis=1), outlines.max(axis=1)], axis=1)


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


def is_at_border(box: Floats, height: int, width: int) -> Bools:
    """Return which boxes, (N, 4), are close enough to the border to leave the picture, (N,)."""
    far = np.array([width, height]) - 1 - LEAVES
    return np.asarray((box[:, :2] <= LEAVES).any(axis=1) | (box[:, 2:] >= far).any(axis=1))
