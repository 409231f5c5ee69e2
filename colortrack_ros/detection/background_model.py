"""A picture of what stands still."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS

Picture = NDArray[Any]

SAMPLES = 5
"""Frames that a new background is the median of."""

RATE = 20.0
"""Levels a second by which the background follows the picture."""

HOLD = 7
"""How many times slower it follows where something was found."""

STRIPS = 8
"""Parts of the picture, of which one follows in each frame."""

GRID = 4096
"""Pixels that the change of the light is estimated from."""

DEAD_BAND = 0.02
"""Changes of the light that are taken for none: noise moves the estimate that much."""


class BackgroundModel:
    """The temporal median of each pixel.

    The first frame counts until the median of five can be taken, learn_seconds later. From then on
    the background goes up or down by a little at a time, which approximates the median, and
    several times slower where something was found, so that an object may rest. The light of the
    whole picture may change: the background is put into the light of each frame.
    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Begin with the next frame."""
        self.median: Picture = np.zeros((0, 0, 0), np.uint8)

    def knows(self, picture: Picture) -> bool:
        """Whether there is a background of the picture's shape."""
        return self.median.shape == picture.shape

    def relight(self, picture: Picture) -> None:
        """Put the background into the light of the picture: a gain for each channel.

        :param picture: (H, W, channels), of a shape that it knows.
        """
        step = max(1, int(np.sqrt(picture.shape[0] * picture.shape[1] / GRID)))
        now, before = (part[::step, ::step].astype(float) for part in (picture, self.median))
        gain = np.median((now + 1) / (before + 1), axis=(0, 1))
        if (np.abs(gain - 1) > DEAD_BAND).any():
            levels = np.clip(np.rint(np.arange(256)[:, None] * gain), 0, 255).astype(np.uint8)
            self.median = cv2.LUT(self.median, levels[:, None]).reshape(picture.shape)

    def follow(
        self, picture: Picture, stamp: int, boxes: NDArray[np.int64], learn_seconds: float
    ) -> None:
        """Learn from a frame.

        :param picture: (H, W, channels).
        :param stamp: of the frame [ns].
        :param boxes: (N, 4) left, top, width, height of what was found and is not background.
        :param learn_seconds: from the first frame to the last of those that a new one is made of.
        """
        if not self.knows(picture):
            self.median = picture.copy()
            self._start, self._samples = stamp, [self.median]
            self._turn, self._followed = 0, [stamp] * STRIPS
        elif len(self._samples) < SAMPLES:
            step = learn_seconds * NANOSECONDS / (SAMPLES - 1)
            if stamp - self._start >= step * len(self._samples):
                self._samples.append(picture.copy())
            if len(self._samples) == SAMPLES:
                self.median = _median_of_five(*self._samples)
        else:
            self._follow(picture, stamp, boxes)

    def _follow(self, picture: Picture, stamp: int, boxes: NDArray[np.int64]) -> None:
        self._turn = (self._turn + 1) % STRIPS
        top, bottom = (len(picture) * turn // STRIPS for turn in (self._turn, self._turn + 1))
        elapsed = (stamp - self._followed[self._turn]) / NANOSECONDS
        usual = np.clip(RATE * elapsed, 0, 255)
        if elapsed < 0 or usual >= HOLD:
            self._followed[self._turn] = stamp
        step = np.full((bottom - top, picture.shape[1], 1), usual, np.uint8)
        for u, v, w, h in boxes:
            step[max(v - top, 0) : max(v + h - top, 0), u : u + w] = usual / HOLD
        now, median = picture[top:bottom], self.median[top:bottom]
        up = np.minimum(np.maximum(now, median) - median, step)
        median -= np.minimum(median - np.minimum(now, median), step)
        median += up


def _median_of_five(a: Picture, b: Picture, c: Picture, d: Picture, e: Picture) -> Picture:
    """The median of each pixel: that of what is left when the extremes are dropped twice."""
    low = np.maximum(np.minimum(a, b), np.minimum(c, d))
    high = np.minimum(np.maximum(a, b), np.maximum(c, d))
    return np.maximum(np.minimum(low, high), np.minimum(e, np.maximum(low, high)))
