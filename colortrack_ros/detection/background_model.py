"""A picture of what stands still."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS

Picture = NDArray[Any]

SAMPLES = 5
"""Frames that a new background is the median of."""

RATES = (20.0, 2.0)
"""Levels a second by which the recent and the lasting background follow the picture."""

HOLD = 7
"""How many times slower they follow where something was found."""

MARGIN = 4
"""What belongs to an object beyond the box of its eroded blob [px]."""

STRIPS = 8
"""Parts of the picture, of which one is followed in each frame."""

GRID = 4096
"""Pixels that the change of the light is estimated from."""

DEAD_BAND = 0.02
"""Changes of the light that are taken for none: noise moves the estimate that much."""


class BackgroundModel:
    """Two pictures of what stands still: the recent one and the lasting one.

    Both start with the first frame, and are the median of five frames learn_seconds later. From
    then on they go up or down by a little at a time, which approximates the median, and several
    times slower where something was found, so that an object may rest. The recent one takes in
    what was put somewhere, and the lasting one still knows what was behind something that paused.
    The light of the whole picture may change: both are put into the light of each frame.
    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Begin with the next frame."""
        self._samples: list[Picture] = []
        self._models: list[Picture] = []

    def knows(self, picture: Picture) -> bool:
        """Whether there is a background of the picture's shape."""
        return bool(self._models) and self._models[0].shape == picture.shape

    def difference(self, picture: Picture) -> Picture:
        """(H, W) distance to the nearer background, mean of the channels [levels].

        :param picture: (H, W, channels), of a shape that it knows.
        """
        mean = np.full((1, picture.shape[2]), 1 / picture.shape[2])
        recent, lasting = (
            cv2.transform(cv2.absdiff(picture, model), mean) for model in self._models
        )
        return cv2.min(recent, lasting)

    def difference_at(self, picture: Picture, pixel: NDArray[np.intp]) -> NDArray[np.float64]:
        """(N,) the same for single pixels.

        :param pixel: (N,) v W + u.
        """
        channels = picture.shape[2]
        now, recent, lasting = (
            part.reshape(-1, channels).take(pixel, axis=0) for part in (picture, *self._models)
        )
        mean = np.full(channels, 1 / channels)
        distances = (
            np.maximum(now, before) - np.minimum(now, before) for before in (recent, lasting)
        )
        return np.minimum(*(distance @ mean for distance in distances))

    def relight(self, picture: Picture) -> None:
        """Put the backgrounds into the light of the picture: a gain for each channel.

        :param picture: (H, W, channels), of a shape that it knows.
        """
        step = max(1, int(np.sqrt(picture.shape[0] * picture.shape[1] / GRID)))
        for model in self._models:
            now, before = (part[::step, ::step].astype(float) for part in (picture, model))
            gain = np.median((now + 1) / (before + 1), axis=(0, 1))
            if (np.abs(gain - 1) > DEAD_BAND).any():
                levels = np.clip(np.rint(np.arange(256)[:, None] * gain), 0, 255)
                model[...] = cv2.LUT(model, levels.astype(np.uint8)[:, None]).reshape(model.shape)

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
            self._start, self._samples = stamp, [picture.copy()]
            self._models = [picture.copy() for _ in RATES]
            self._turn, self._followed = 0, np.full((len(RATES), STRIPS), stamp)
        elif len(self._samples) < SAMPLES:
            step = learn_seconds * NANOSECONDS / (SAMPLES - 1)
            if stamp - self._start >= step * len(self._samples):
                self._samples.append(picture.copy())
            if len(self._samples) == SAMPLES:
                self._models = [_median_of_five(*self._samples) for _ in RATES]
        else:
            self._turn = (self._turn + 1) % STRIPS
            for k in range(len(RATES)):
                self._follow_strip(k, picture, stamp, boxes)

    def _follow_strip(self, k: int, picture: Picture, stamp: int, boxes: NDArray) -> None:
        usual = RATES[k] * (stamp - self._followed[k, self._turn]) / NANOSECONDS
        if 0 <= usual < HOLD:
            return
        self._followed[k, self._turn] = stamp
        top, bottom = (len(picture) * turn // STRIPS for turn in (self._turn, self._turn + 1))
        step = np.full((bottom - top, picture.shape[1], 1), np.clip(usual, 0, 255), np.uint8)
        held = np.zeros(step.shape[:2], bool)
        for left, upper, width, height in boxes:
            rows = slice(max(upper - MARGIN - top, 0), max(upper + height + MARGIN - top, 0))
            held[rows, max(left - MARGIN, 0) : left + width + MARGIN] = True
        step[held] //= HOLD
        now, model = picture[top:bottom], self._models[k][top:bottom]
        up = np.minimum(np.maximum(now, model) - model, step)
        model -= np.minimum(model - np.minimum(now, model), step)
        model += up


def _median_of_five(a: Picture, b: Picture, c: Picture, d: Picture, e: Picture) -> Picture:
    """The median of each pixel: that of what is left when the extremes are dropped twice."""
    low = np.maximum(np.minimum(a, b), np.minimum(c, d))
    high = np.minimum(np.maximum(a, b), np.maximum(c, d))
    return np.maximum(np.minimum(low, high), np.minimum(e, np.maximum(low, high)))
