"""Borders: where the picture ends, learned from boxes if its size is not given."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.tracking.sizes import TOLERANCE

TOUCHING = 1.0
"""A blob this close to the picture's border touches it [px]: erosion removes a pixel."""

OUTWARD = np.array([[-1.0], [1.0]])
"""Sign of the low and the high side of a box."""


class Borders:
    """Lines that no box crosses, and at which boxes of several sizes end.

    Objects that enter or leave end there with a changing size; those that stand there have one
    size. Coordinates are assumed to start at 0 until a box goes beyond.
    """

    def __init__(self) -> None:
        self._line = np.array([[0.5, 0.5], [-np.inf, -np.inf]])
        self._least = np.array([[0.0, 0.0], [np.inf, np.inf]])
        self._most = np.array([[np.inf, np.inf], [-np.inf, -np.inf]])

    def learn(self, box: Floats, size: NDArray[np.floating]) -> None:
        """Learn from the boxes of a frame.

        :param box: (M, 2, 2) low and high sides, by axis (u, v) [px].
        :param size: (M, 2) [px], 0 for points, which are ignored.
        """
        side = OUTWARD * box
        if not np.count_nonzero(side >= self._line - TOUCHING):
            return  # as nearly always: what ends at no line moves none
        known = (size > 0).all(axis=1)
        if not np.count_nonzero(known):
            return
        side, size = side[known], size[known, None]
        farthest = side.max(axis=0)
        beyond = farthest > self._line + TOUCHING
        self._least[beyond], self._most[beyond] = np.inf, -np.inf
        self._line = np.maximum(self._line, farthest)
        ends = side >= self._line - TOUCHING
        self._least = np.minimum(self._least, np.where(ends, size, np.inf).min(axis=0))
        self._most = np.maximum(self._most, np.where(ends, size, -np.inf).max(axis=0))

    def touched(self, box: Floats) -> Bools:
        """Which low and high sides of boxes, (M, 2, 2), end at such a line, by axis, (M, 2, 2)."""
        seen = self._most - self._least > TOLERANCE
        ends = (OUTWARD * box >= self._line - TOUCHING) & seen
        return np.asarray(ends)
