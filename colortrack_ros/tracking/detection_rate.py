"""Detection probability: how often a visible object is detected, and what that tells of a track."""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.tracking.resolution import LEFT

RATE_PRIOR = 30.0
"""Weight of the given probability, in detections. Assumed."""

LEAST_RATE = 0.3
"""Least estimate: objects detected less often cannot be told from clutter. Assumed."""

OBJECT_ODDS = 4.0
"""Odds that a confirmed track is an object rather than clutter. Assumed; with 1 and 9, mean IDF1 of
five sets of detections of networks changes by 0.007 at most."""

BLOB_EXPONENT = 4.0
"""The exponent a of flickering() for blobs: those that shade or others cover in part are missed
more often than the rest, and are no clutter. What is found 0.4 times as often as the others then is
as likely clutter. Assumed."""


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


def flickering(hits: Floats, misses: Floats, detected: Floats | float, *, whole: bool) -> Floats:
    """Probability, (K,), that confirmed tracks are clutter that flickers in its place.

    The probabilities p with which objects are detected have the density a p^(a - 1), whose mean is
    a / (a + 1); those of such clutter 2 (1 - p): mostly it is not there. Of a track, p is estimated
    by Laplace's rule of succession; of blobs, relative to that of the others.

    :param hits, misses: (K,) frames in which each was measured, and was not.
    :param detected: mean probability of detecting a visible object, or (K,) of them, below 1.
    :param whole: whether the detector finds whole objects.
    """
    p = (hits + 1) / (hits + misses + 2)
    a: Floats | float = BLOB_EXPONENT
    if whole:
        a = detected / (1 - detected)
    else:
        p = np.minimum(p / detected, 1.0)
    clutter = 2 - 2 * p
    return np.asarray(clutter / (clutter + OBJECT_ODDS * a * p ** (a - 1)))
