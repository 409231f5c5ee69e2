"""Detection probability: how often a visible object is detected."""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.tracking.resolution import LEFT

RATE_PRIOR = 30.0
"""Weight of the given probability, in detections. Assumed."""

LEAST_RATE = 0.3
"""Least estimate: objects detected less often cannot be told from clutter. Assumed."""


class DetectionRate:
    """Learns the probability from the number of frames between two detections of an object.

    That is geometrically distributed: of the detections after one or two frames, a share of
    1 / (2 - p) comes after one. Longer gaps, in which the object may have been occluded, do not
    count.
    """

    def __init__(self) -> None:
        self._next, self._second = 0.0, 0.0

    def learn(self, frames: Floats) -> None:
        """Add the frames, (K,), since the previous detections of objects detected now."""
        following = np.count_nonzero(frames < 1.5)
        self._next = LEFT * self._next + following
        self._second = LEFT * self._second + np.count_nonzero(frames < 2.5) - following

    def estimate(self, most: float) -> float:
        """The probability, which starts at the given one and never exceeds it."""
        if not self._second:
            return most
        first = self._next + RATE_PRIOR / (2 - most)
        second = self._second + RATE_PRIOR * (1 - most) / (2 - most)
        return min(most, max(1 - second / first, LEAST_RATE))
