"""Background of a busy scene: what has stood still longest at each pixel."""

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.areas import Mask
from colortrack_ros.data import Bools
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.background_model import BackgroundModel
from colortrack_ros.detection.background_model import LEARN_FRAMES
from colortrack_ros.detection.background_model import Picture
from colortrack_ros.detection.blobs import BlobTable

STILLNESS_STEP = 0.1
"""Least time between looks [s]; with 0.04 the MOTA of TUD Campus is -0.11 and not
-0.16, of PETS S3.MF1 0.70 as it is (before agreement.ALONE_SECONDS;
benchmark/notes/contours.md)."""

STILL_LEVELS = 10.0
"""Largest mean change of the channels of a pixel that stands still [levels]: half of
difference_threshold, to keep what stands still out of the foreground. With 6 the same two are -0.15
and 0.69."""

KNOWN_SECONDS = 0.3
"""What has stood still for this time is background, until something else does so for longer [s];
with 0.2 the same two are -0.26 and 0.65."""

THING_EDGES = 4.0
"""Least ratio of the edges around a difference, in the picture over those in the background, for it
to be a thing. With 1 or 2 the scene `silhouette` is the same; MOTA of KITTI-17 and of `pets` is
-0.83 and 0.62 with 1, -0.76 and 0.53 with 2, -0.77 and 0.58 with 4 as without."""

CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
"""A pixel and its four neighbors."""

LAST_LOOK = 10.0
"""Time after which nothing more is learned where nothing has stood still for learn_seconds [s]; the
same as CLUTTER_SECONDS.
Half and twice the value change 0.01 of IDF1 and precision on PETS S3.MF1, nothing on TUD Campus
(``benchmark/real_contours.py FOLDER --constants background.LAST_LOOK``)."""


class StillBackground(BackgroundModel):
    """A background model that starts with what has stood still longest, for at most learn_seconds.

    A median of five pictures shows what is there in three of them, and needs all five: where people
    keep walking, it contains parts of them. They stand still for less time than what is behind
    them, and a place where nothing has stood still yet is unknown.
    """

    def restart(self) -> None:
        """Start over with the next frame."""
        super().restart()
        self._stillness: Stillness | None = None

    @property
    def pictures(self) -> list[Picture]:
        """The recent and the lasting background, (H, W, channels) each."""
        return self._models

    @property
    def is_learning(self) -> bool:
        """Whether less than learn_seconds have passed since the first picture."""
        return self._stillness is not None and self._stillness.seconds < self._most

    @property
    def seconds(self) -> float:
        """Time since the first picture [s], while some of the background is unknown; 0 later."""
        return 0.0 if self._stillness is None else self._stillness.seconds

    @property
    def has_looked(self) -> bool:
        """Whether the last frame was compared with earlier ones, which takes time."""
        return self._stillness is not None and self._stillness.seconds == self._stillness.last

    def unknown(self) -> Bools | None:
        """Return where the background is unknown, (H, W); None if it is known everywhere."""
        return None if self._stillness is None else self._stillness.longest < self._least

    def settled(self) -> Bools | None:
        """Return where the background is known for good, (H, W); None if it is everywhere."""
        return None if self._stillness is None else self._stillness.longest >= self._most

    def follow(self, picture: Picture, stamp: int, blobs: BlobTable, learn_seconds: float) -> None:
        """Learn from a frame; see BackgroundModel."""
        if learn_seconds <= 0:
            super().follow(picture, stamp, blobs, learn_seconds)
            return
        if not self.knows(picture):
            super().follow(picture, stamp, blobs, learn_seconds)
            self._samples = [picture] * LEARN_FRAMES  # no median is needed
            self._stillness = Stillness(picture, stamp)
            self._least, self._most = min(KNOWN_SECONDS, learn_seconds), learn_seconds
            return
        if self._stillness is not None:
            new = self._stillness.look(picture, stamp, learn_seconds, self._models[0])
            for model in self._models:
                cv2.copyTo(self._stillness.value, new, model)
            if self._stillness.is_over:
                self._stillness = None
        super().follow(picture, stamp, blobs, learn_seconds)


class Stillness:
    """Value of each pixel, and the time for which it has had it.

    The value is that of the second look after a change: the first one may contain the edge of what
    has left, and the last one that of what comes.

    :param picture: (H, W, channels), the first one.
    :param stamp: of the picture [ns].
    :ivar value: (H, W, channels) of each pixel since it changed.
    :ivar longest: (H, W) longest time for which it has stood still [s].
    :ivar seconds: time since the first picture [s].
    :ivar last: time of the last look, like seconds.
    :ivar is_over: whether nothing is left to learn.
    """

    def __init__(self, picture: Picture, stamp: int) -> None:
        self.value, self._soft = picture.copy(), softened(picture)
        self.longest = np.zeros(picture.shape[:2], np.float32)
        self._since = self.longest.copy()
        self._is_longest: Bools = np.ones(picture.shape[:2], bool)
        self._stamp, self.seconds, self.last = stamp, 0.0, 0.0
        self.is_over = False

    def look(self, picture: Picture, stamp: int, most: float, background: Picture) -> Mask:
        """Take the next picture.

        :param most: after this time of standing still, a value is final [s].
        :param background: (H, W, channels) the current one.
        :return: (H, W) 1 where the value has just become the one that has stood still longest.
        """
        self.seconds += max(stamp - self._stamp, 0) / NANOSECONDS
        self._stamp = stamp
        if self.seconds - self.last < STILLNESS_STEP:
            return np.zeros(picture.shape[:2], np.uint8)
        soft = softened(picture)
        moved = _apart(soft, self._soft)
        second = ~moved & (self._since == np.float32(self.last))
        cv2.copyTo(soft, (moved | second).astype(np.uint8), self._soft)
        cv2.copyTo(picture, second.astype(np.uint8), self.value)
        self.last = self.seconds
        self._since[moved], self._is_longest[moved] = self.seconds, False
        still = self.seconds - self._since
        longer = (still > self.longest) & ~moved
        new = longer & ~self._is_longest & (self.longest < most)
        if new.any():
            known = self.longest > 0
            new &= ~(known & _of_things(soft, softened(background)))
        self._is_longest |= new
        longer &= self._is_longest
        self.longest[longer] = still[longer]
        self.is_over = self.seconds > LAST_LOOK or bool(self.longest.min() >= most)
        return new.astype(np.uint8)


def _apart(one: Picture, other: Picture) -> Bools:
    """Return where pictures differ by more than STILL_LEVELS, (H, W)."""
    mean = np.full((1, one.shape[2]), 1 / one.shape[2])
    return np.asarray(cv2.transform(cv2.absdiff(one, other), mean) > STILL_LEVELS)


def _of_things(soft: Picture, background: Picture) -> Bools:
    """Return where a difference from the background is a thing, not the place that one has left.

    A thing has edges around it in the picture, a place that it has left in the background.
    """
    differs, things = _apart(soft, background).astype(np.uint8), np.zeros(soft.shape[:2], bool)
    left, top, width, height = cv2.boundingRect(differs)
    part = np.s_[max(top - 1, 0) : top + height + 1, max(left - 1, 0) : left + width + 1]
    outline = cv2.erode(differs[part], CROSS) < differs[part]
    count, label = cv2.connectedComponents(differs[part], connectivity=4)
    now, before = (
        np.bincount(label[outline], edges_at(each[part], outline), count)
        for each in (soft, background)
    )
    things[part] = (now > THING_EDGES * before)[label]
    return things


def edges_at(picture: Picture, where: Bools | tuple[Indices, Indices]) -> NDArray[np.int64]:
    """Return the gradients, (n,), of the pixels there, summed over the channels [levels].

    :param where: (H, W), or rows and columns, (n,).
    """
    steps = cv2.morphologyEx(picture, cv2.MORPH_GRADIENT, CROSS)
    return np.asarray(steps.reshape(picture.shape)[where].sum(axis=1, dtype=np.int64))


def softened(picture: Picture) -> NDArray[np.uint8]:
    """Return the mean of each pixel and its neighbors, against noise."""
    return np.asarray(cv2.blur(picture, (3, 3)).reshape(picture.shape), np.uint8)
