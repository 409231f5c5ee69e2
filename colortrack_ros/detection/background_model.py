"""Background model: pictures of the static scene."""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.blobs import sample_pixels
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter

Picture = NDArray[Any]

# `python benchmark/detection_quality.py --constants` prints the effect on the detections of halving
# or doubling each constant below.

LEARN_FRAMES = 5
"""Number of frames whose median is a new background: the fewest that tolerate two with an object in
the way. :func:`_median_of_five` is written for five."""

FOLLOW_RATES = (20.0, 2.0)
"""Rates at which the recent and the lasting background follow the picture [levels/s]: they absorb a
contrast of 100 levels in 5 s and in 50 s."""

HELD_SLOWDOWN = 7
"""Factor by which they slow down at detections. In `python benchmark/detection_quality.py
--constants`, half of it changes nothing; with twice it, there are 0.08 false blobs per frame, not
0.02."""

OBJECT_MARGIN = 4
"""Margin of an object around the box of its eroded blob [px]: 1 px for an erosion of 3, and the
blur of its outline."""

OUTLINE_REACH = 3
"""Distance inside and outside a blob's outline at which its contrast is measured [px]: beyond
blur."""

GHOST_CONTRAST = 2.0
"""Least ratio of the outline contrast that is only in the backgrounds to that only in the picture,
for a ghost. Chosen: `python benchmark/detection_quality.py --constants` gives the same with half
and twice."""

STILL_SECONDS = 0.5
"""Time for which a blob must not change to count as static [s]. Assumed: things in motion rest for
less."""

STILL_CHANGE = 6.0
"""Largest mean change of a static blob's pixels [levels]: twice the difference of two pictures with
noise of 2.5 levels, 2.5 sqrt(2) sqrt(2 / pi) = 2.8."""

STILL_PIXELS = 64
"""Number of pixels in which the change of a blob is measured: their mean is known to 1/8 of the
noise."""

STRIPS = 8
"""Number of strips of the picture. Each frame updates one of them, at an eighth of the cost. At
30 Hz FOLLOW_RATES then change a pixel by at most 5 levels at once, twice the noise of a camera."""

RELIGHT_PIXELS = 4096
"""Number of pixels whose median ratio is the change of the light: known to 2 % of their spread."""

DENSE_SHARE = 0.05
"""Share of the picture's pixels from which comparing all of them is faster than comparing single
ones; `python benchmark/detection.py` measures both sides of it."""

SATURATED = 255
"""Value from which a sum of differences in a byte is not exact."""

LIGHT_DEAD_BAND = 0.02
"""Relative changes of the light up to this are estimation noise, and are ignored. Assumed: 2 % of
middle gray are 2 levels, the noise of a camera."""


@dataclass(frozen=True)
class BackgroundModelConfig(Config):
    """How methods use the learned background."""

    difference_threshold: float = parameter(
        8.0,
        'A pixel moves where it differs by more from the learned background, in the mean of the '
        'channels; for moving_only and the background model median.',
        unit='levels',
        limits=(0.0, 254.0),
        audience=EXPERT,
    )
    learn_seconds: float = parameter(
        1.0,
        'How long a new background is learned, so that what moves meanwhile is not part of it.',
        unit='s',
        limits=(0.0, 3600.0),
        audience=EXPERT,
    )


class BackgroundModel:
    """Two pictures of the static scene: a recent and a lasting background.

    Both start as the first frame, and become the median of five frames spread over learn_seconds.
    Then they move up or down in small steps, which approximates the median. At detections they do
    so several times slower, so an object may rest. The recent one absorbs an object that was put
    down; the lasting one still shows what was behind an object that paused. If an object leaves
    that was there from the start, its ghost is recognized and absorbed. When the light of the whole
    picture changes, both are adjusted to the light of the frame.
    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Restart with the next frame."""
        self._samples: list[Picture] = []
        self._models: list[Picture] = []
        self._before = 0, np.zeros(0, np.uint8)

    def knows(self, picture: Picture) -> bool:
        """Whether there is a background with the shape of the picture."""
        return bool(self._models) and self._models[0].shape == picture.shape

    def difference(self, picture: Picture) -> Picture:
        """(H, W) distance to the nearer background, averaged over channels [levels].

        :param picture: (H, W, channels), of a known shape.
        """
        mean = np.full((1, picture.shape[2]), 1 / picture.shape[2])
        recent, lasting = (
            cv2.transform(cv2.absdiff(picture, model), mean) for model in self._models
        )
        return cv2.min(recent, lasting)

    @property
    def recent(self) -> Picture:
        """(H, W, channels) the recent background."""
        return self._models[0]

    def moves(self, picture: Picture, threshold: float) -> Picture:
        """(H, W) 255 where a picture differs from both backgrounds, else 0.

        :param picture: (H, W, channels), of a known shape.
        :param threshold: for the mean of the channels' differences, below 85 [levels].
        """
        ones = np.ones((1, picture.shape[2]))
        sums = [cv2.transform(cv2.absdiff(picture, model), ones) for model in self._models]
        greatest = int(threshold * picture.shape[2])
        return cv2.threshold(cv2.min(*sums), greatest, 255, cv2.THRESH_BINARY)[1]

    def clear_still(self, picture: Picture, image: LabelImage, threshold: float) -> None:
        """Clear the labels, in place, where the picture matches one of the backgrounds.

        :param picture: (H, W, channels), of a known shape.
        :param threshold: for the mean of the channels' differences [levels].
        """
        greatest = int(threshold * picture.shape[2])  # of their sum, which is an integer
        labeled = np.count_nonzero(image.padded)
        if labeled > DENSE_SHARE * image.padded.size and greatest < SATURATED:
            cv2.bitwise_and(image.pixels, self.moves(picture, threshold), dst=image.pixels)
            return
        position = image.positions()
        v, u = np.divmod(position, image.stride)
        still = self._sum_at(picture, v * image.width + u) <= greatest
        image.padded.reshape(-1)[position[still]] = 0

    def _sum_at(self, picture: Picture, pixel: NDArray[np.intp]) -> NDArray[np.integer]:
        """(N,) difference to the nearer background, summed over channels [levels].

        :param pixel: (N,) v W + u.
        """
        now, recent, lasting = (
            part.reshape(-1, picture.shape[2]).take(pixel, axis=0)
            for part in (picture, *self._models)
        )
        sums = (
            (np.maximum(now, before) - np.minimum(now, before)).sum(axis=1)
            for before in (recent, lasting)
        )
        return np.minimum(*sums)

    def relight(self, picture: Picture) -> None:
        """Adjust the backgrounds to the light of the picture, with a gain for each channel.

        :param picture: (H, W, channels), of a known shape.
        """
        step = max(1, int(np.sqrt(picture.shape[0] * picture.shape[1] / RELIGHT_PIXELS)))
        for model in self._models:
            now, before = (part[::step, ::step].astype(float) for part in (picture, model))
            gain = np.median((now + 1) / (before + 1), axis=(0, 1))
            if (np.abs(gain - 1) > LIGHT_DEAD_BAND).any():
                levels = np.clip(np.rint(np.arange(256)[:, None] * gain), 0, 255)
                model[...] = cv2.LUT(model, levels.astype(np.uint8)[:, None]).reshape(model.shape)

    def follow(self, picture: Picture, stamp: int, blobs: BlobTable, learn_seconds: float) -> None:
        """Learn from a frame.

        :param picture: (H, W, channels).
        :param stamp: of the frame [ns].
        :param blobs: detections, which are not background.
        :param learn_seconds: time from the first to the last frame of a new background.
        """
        if not self.knows(picture):
            self._start, self._samples = stamp, [picture.copy()]
            self._models = [picture.copy() for _ in FOLLOW_RATES]
            self._before = stamp, self._samples[0]
            self._turn, self._followed = 0, np.full((len(FOLLOW_RATES), STRIPS), stamp)
        elif len(self._samples) < LEARN_FRAMES:
            step = learn_seconds * NANOSECONDS / (LEARN_FRAMES - 1)
            if stamp - self._start >= step * len(self._samples):
                self._samples.append(picture.copy())
            if len(self._samples) == LEARN_FRAMES:
                self._models = [_median_of_five(*self._samples) for _ in FOLLOW_RATES]
        else:
            self._turn = (self._turn + 1) % STRIPS
            for k in range(len(FOLLOW_RATES)):
                self._follow_strip(k, picture, stamp, blobs.box)
        self._heal(picture, stamp, blobs)

    def _heal(self, picture: Picture, stamp: int, blobs: BlobTable) -> None:
        """Absorb ghosts: blobs that an object has left, but where the backgrounds still show it.

        A ghost is static, and its outline shows in the backgrounds, but not in the picture.
        """
        age = (stamp - self._before[0]) / NANOSECONDS
        if not 0 <= age < 2 * STILL_SECONDS:
            self._before, age = (stamp, picture.copy()), 0.0
        if age < STILL_SECONDS or not len(blobs.area):
            return
        blob, position = sample_pixels(blobs, STILL_PIXELS)
        pixel = np.divmod(position, blobs.runs.stride)
        change = np.abs(picture[pixel].astype(int) - self._before[1][pixel]).mean(axis=-1)
        still = blobs.take(np.bincount(blob, change) / np.bincount(blob) < STILL_CHANGE)
        row, left, right = still.take(self._has_left(picture, still)).runs.ends()
        for v, start, end in zip(row, left - OBJECT_MARGIN, right + OBJECT_MARGIN, strict=True):
            for model in self._models:
                model[v, max(start, 0) : end] = picture[v, max(start, 0) : end]

    def _has_left(self, picture: Picture, blobs: BlobTable) -> NDArray[np.bool_]:
        """(N,) whether more of a blob's outline contrast has left the picture than has appeared."""
        if not len(blobs.area):
            return np.zeros(0, bool)
        row, left, right = blobs.runs.ends()
        columns = np.stack(
            [
                left - OUTLINE_REACH,
                left + OUTLINE_REACH - 1,
                right - OUTLINE_REACH,
                right + OUTLINE_REACH - 1,
            ]
        )
        columns = columns.clip(0, picture.shape[1] - 1)

        def contrast(part: Picture) -> NDArray[np.int64]:
            a, b, c, d = part[row, columns].astype(np.int64).sum(axis=-1)
            return np.abs(a - b) + np.abs(c - d)

        gone = np.minimum(*(contrast(model) for model in self._models)) - contrast(picture)
        lost, come = np.add.reduceat(np.maximum([gone, -gone], 0), blobs.first_run, axis=1)
        return np.asarray(lost > GHOST_CONTRAST * come)

    def _follow_strip(self, k: int, picture: Picture, stamp: int, boxes: NDArray) -> None:
        usual = FOLLOW_RATES[k] * (stamp - self._followed[k, self._turn]) / NANOSECONDS
        if 0 <= usual < HELD_SLOWDOWN:
            return
        self._followed[k, self._turn] = stamp
        top, bottom = (len(picture) * turn // STRIPS for turn in (self._turn, self._turn + 1))
        step = np.full((bottom - top, picture.shape[1], 1), np.clip(usual, 0, 255), np.uint8)
        held = np.zeros(step.shape[:2], bool)
        for left, upper, width, height in boxes:
            rows = slice(
                max(upper - OBJECT_MARGIN - top, 0), max(upper + height + OBJECT_MARGIN - top, 0)
            )
            held[rows, max(left - OBJECT_MARGIN, 0) : left + width + OBJECT_MARGIN] = True
        step[held] //= HELD_SLOWDOWN
        now, model = picture[top:bottom], self._models[k][top:bottom]
        up = np.minimum(np.maximum(now, model) - model, step)
        model -= np.minimum(model - np.minimum(now, model), step)
        model += up


def _median_of_five(a: Picture, b: Picture, c: Picture, d: Picture, e: Picture) -> Picture:
    """The median of each pixel: dropping both extremes twice leaves it."""
    low = np.maximum(np.minimum(a, b), np.minimum(c, d))
    high = np.minimum(np.maximum(a, b), np.maximum(c, d))
    return np.maximum(np.minimum(low, high), np.minimum(e, np.maximum(low, high)))
