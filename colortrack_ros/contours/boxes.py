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


def is_at_border(box: Floats, height: int, width: int) -> Bools:
    """Return which boxes, (N, 4), are close enough to the border to leave the picture, (N,)."""
    far = np.array([width, height]) - 1 - LEAVES
    return np.asarray((box[:, :2] <= LEAVES).any(axis=1) | (box[:, 2:] >= far).any(axis=1))
