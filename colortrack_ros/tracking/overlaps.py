"""Overlaps: whether detections of objects before each other overlap, or merge.

Of touching blobs of one color a threshold makes one, with one box around all. Who looks for whole
objects, as networks do, has a box for each, and the boxes overlap. There a box of another size is
not a merged blob, nor a cut one, nor is a small one beside it a piece: it is an error of the box.
"""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.tracking.rectangles import points_inside

Floats = NDArray[np.float64]

LIKE_SIDES = 2.0
"""Boxes are compared of which no side is more than so many times as long as the other's: what is
smaller is a piece, or lies on what it is compared with. Assumed."""

RESOLVED_SHARE = 0.2
"""Of overlapping and merged ones, from which objects are said to be resolved. Assumed: of those
that a network does not tell apart, many seem to be merged. With 0.5 pedestrians of two detectors
lose 3 points of IDF1."""

FIRST_MERGED = 10.0
"""Objects taken for merged before any are seen. Assumed: three overlap before that is believed."""

SEEN_EVERY = 5
"""Frames from one look at the boxes to the next, to save time. Assumed, as recent.EVERY."""

REMAINING = 0.99
"""Of what was counted, at each look: a memory of 500 frames. Assumed, as resolution.LEFT."""

MOST_OVERLAPPING = 8
"""Boxes compared with each, to bound the time. Assumed."""


class Overlaps:
    """Counts detections that overlap, and objects that share one.

    :ivar are_resolved: whether objects before each other have detections of their own.
    """

    def __init__(self) -> None:
        self.are_resolved = False
        self._overlapping, self._merged, self._frame = 0.0, 0.0, 0

    def look(self, box: Floats, color: NDArray[np.uint32]) -> None:
        """Count, every few frames, boxes of which one has the center of another in it.

        :param box: (M, 2, 2) see Measurements; color: (M,) of the detections.
        """
        self._frame += 1
        if self._frame % SEEN_EVERY:
            return
        center, sides = box.mean(axis=1), box[:, 1] - box[:, 0]
        one, other = points_inside(center, sides / 2, center, MOST_OVERLAPPING)
        pair = (one != other) & (color[one] == color[other])
        one, other = one[pair], other[pair]
        size, beside = sides[one], sides[other]
        like = (np.maximum(size, beside) < LIKE_SIDES * np.minimum(size, beside)).all(axis=1)
        self._overlapping = REMAINING * self._overlapping + SEEN_EVERY * np.count_nonzero(like) / 2
        self._merged *= REMAINING
        self.are_resolved = self._overlapping > RESOLVED_SHARE * (
            self._overlapping + self._merged + FIRST_MERGED
        )

    def count_merged(self, count: int) -> None:
        """Take the objects of a frame that seem to share the detections of others."""
        self._merged += count
