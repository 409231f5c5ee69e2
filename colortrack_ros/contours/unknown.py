"""Boxes that end where the background is unknown: parts of things that go on there."""

import cv2
import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats

STRIP_WIDTH = 2
"""Width of the strip beside a side of a box that is looked at [px]: the opening takes one off."""

UNKNOWN_SIDE = 0.5
"""Share of the strip above which the thing may end anywhere: most of it. Of 408 false boxes told
while some background was unknown (ten runs of five clips) 74 are above it, of 1,905 true ones 29;
above 0.7 28 and 7 (benchmark/notes/contours.md)."""


def goes_on(box: Floats, unknown: Bools) -> Bools:
    """Return which boxes, (N, 4), have a side beside which most of the background is unknown.

    :param box: left, top, right, bottom, the first and last column and row [px].
    :param unknown: (H, W) where it is.
    """
    left, top, right, bottom = np.rint(box).astype(int).T
    right, bottom = right + 1, bottom + 1
    strips = np.array(
        [
            [left - STRIP_WIDTH, top, left, bottom],
            [left, top - STRIP_WIDTH, right, top],
            [right, top, right + STRIP_WIDTH, bottom],
            [left, bottom, right, bottom + STRIP_WIDTH],
        ]
    )
    size = np.tile(unknown.shape[::-1], 2)
    left, top, right, bottom = np.moveaxis(strips.clip(0, size[:, None]), 1, 0)
    sums = cv2.integral(unknown.view(np.uint8))
    there = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
    return np.asarray((there > UNKNOWN_SIDE * (right - left) * (bottom - top)).any(axis=0))
