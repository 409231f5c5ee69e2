"""How often an object is detected while it can be seen."""

import numpy as np
from numpy.typing import NDArray

RATE_PRIOR = 30.0
"""Detections that the probability which is given is worth. Assumed."""

RATE_MEMORY = 0.99
"""Of what was counted, at each look: a memory of 500 frames. Assumed, as resolution.RATE_MEMORY."""

LEAST_RATE = 0.3
"""Detected less often, nothing is told from clutter. Assumed."""


class DetectionRate:
    """Learns the probability from how many frames are between two detections of an object.

    They are geometric, so that of those after one frame or two a share of 1 / (2 - p) is after one.
    Longer ones, in which objects may have been hidden, do not count.
    """

    def __init__(self) -> None:
        self._next, self._second = 0.0, 0.0

    def learn(self, frames: NDArray[np.float64]) -> None:
        """Take the numbers of frames, (K,), since the last detections of objects detected now."""
        following = np.count_nonzero(frames < 1.5)
        self._next = RATE_MEMORY * self._next + following
        self._second = RATE_MEMORY * self._second + np.count_nonzero(frames < 2.5) - following

    def estimate(self, most: float) -> float:
        """The probability; no more than is given, as which it begins."""
        if not self._second:
            return most
        first = self._next + RATE_PRIOR / (2 - most)
        second = self._second + RATE_PRIOR * (1 - most) / (2 - most)
        return min(most, max(1 - second / first, LEAST_RATE))
