"""Labels of a picture of which only what outlasts an erosion is needed, from a part of its pixels.

A pixel outlasts an erosion with a square of side s only if it is in the middle of s labeled rows of
s labeled pixels, and one of those is among every s-th row of the picture. So those are labeled
first, and the rest where they hold anything, word by word. Most of a picture need not be labeled.
"""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.label_image import WORD

LABELED_SHARE = 0.25
"""Share of the picture that may be labeled word by word; where it is larger, to label all of it
takes as long. The constants of this file set the time alone, which `python benchmark/detection.py`
measures."""

WORTHWHILE_PIXELS = 1 << 19
"""Pixels of the smallest picture in which it is worth it: below, to label all takes as long."""

PICTURES_OF_PAUSE = 16
"""Pictures for which that is not tried again where the share is larger. Assumed: a try in 16 costs
little, and half a second at 30 Hz is soon enough."""

LabelRows = Callable[[NDArray[np.uint8]], LabelImage]
"""The labels of a part of the picture."""

LabelPixels = Callable[[NDArray[np.uint8]], NDArray[np.uint8]]
"""(1, N) labels of pixels, (1, N, channels)."""


class Survivors:
    """Labels all that outlasts an erosion.

    :param connected: what is connected to it is labeled, too, whatever the labels.
    """

    def __init__(self, connected: bool) -> None:
        self._connected = connected
        self._pause = 0

    def label(
        self,
        picture: NDArray[np.uint8],
        size: int,
        label_rows: LabelRows,
        label_pixels: LabelPixels,
    ) -> LabelImage | None:
        """The labels, 0 where nothing outlasts; None where to label all takes as long.

        :param picture: (H, W, channels).
        :param size: side of the square, odd [px].
        """
        height, width = picture.shape[:2]
        self._pause = max(self._pause - 1, 0)
        if size == 1 or height * width < WORTHWHILE_PIXELS or self._pause:
            return None
        step, pixel = picture.strides[0], picture.shape[2]
        if height < 2 * size or width < WORD or picture.strides[1:] != (pixel, 1) or step < 0:
            return None
        image = LabelImage.empty(height, width)
        image.padded[:-size] = 0
        # Of the last rows all pixels: words are taken together with the row below.
        image.padded[-size:] = label_rows(picture[-size:]).padded
        sampled = label_rows(picture[size // 2 :: size])
        if not self._label_words(image, picture, _words_near(sampled, size), size, label_pixels):
            self._pause = PICTURES_OF_PAUSE
            return None
        return image

    def _label_words(
        self,
        image: LabelImage,
        picture: NDArray[np.uint8],
        words: NDArray[np.intp],
        size: int,
        label_pixels: LabelPixels,
    ) -> bool:
        """Label words but for those of the last rows, in place; False where they are too many."""
        count, below = len(image.words), image.stride // WORD
        last = np.arange(count - size * below, count)
        words = words[: np.searchsorted(words, last[0])]
        around = below + 1
        known = np.ones(count + 2 * around, bool)
        known[around : last[0] + around] = False
        found = [last]
        while len(words):
            found.append(words)
            if sum(map(len, found)) > LABELED_SHARE * count:
                return False
            image.words[words] = label_pixels(_pixels_of(picture, words)).view(np.uint64)[0]
            image.padded[:, image.width :] = 0
            if not self._connected:
                break
            known[words + around] = True
            seen = words if len(found) > 2 else np.append(words, last)
            words = _words_beside(image, seen, known)
        image.filled = np.concatenate([*found[1:], last])
        if len(found) > 2:
            image.filled.sort()
        return True


def _words_near(sampled: LabelImage, size: int) -> NDArray[np.intp]:
    """Ascending numbers of the words in which something may outlast; some are below the picture.

    :param sampled: the labels of every row of which there is one in any square of that side.
    """
    near = sampled.words != 0
    if np.count_nonzero(near) > LABELED_SHARE / 2 * near.size:
        opened = LabelImage.empty(*sampled.pixels.shape)
        along = np.ones((1, size), np.uint8)
        cv2.morphologyEx(sampled.pixels, cv2.MORPH_OPEN, along, dst=opened.pixels)
        near = opened.words != 0
    near = near.reshape(len(sampled.padded), -1)
    # Of the rows that end with a sampled one: in a square with it, or with the one before.
    near[1:] |= near[:-1].copy()
    return np.flatnonzero(near.repeat(size, axis=0)[size - 1 - size // 2 :])


def _words_beside(
    image: LabelImage, words: NDArray[np.intp], known: NDArray[np.bool_]
) -> NDArray[np.intp]:
    """Ascending numbers of the words not yet known that pixels of some may be connected to.

    :param known: which are, with one more than a row before the first and after the last.
    """
    below = image.stride // WORD
    filled = image.words[words]
    labels = filled.view(np.uint8).reshape(-1, WORD)
    ways = (
        (words[filled != 0], (-below, below)),
        (words[labels[:, 0] != 0], (-below - 1, -1, below - 1)),
        (words[labels[:, -1] != 0], (-below + 1, 1, below + 1)),
    )
    beside = [
        some[~known.take(some + (below + 1 + step))] + step
        for some, steps in ways
        for step in steps
    ]
    return np.unique(np.concatenate(beside))


def _pixels_of(picture: NDArray[np.uint8], words: NDArray[np.intp]) -> NDArray[np.uint8]:
    """(1, 8 N, channels) the pixels of words; in those that end a row, of the next one as well.

    :param picture: (H, W, channels).
    :param words: (N,) numbers in its label image, but for the last row.
    """
    height, width, channels = picture.shape
    step, size, per_row = picture.strides[0], WORD * channels, width // WORD + 1
    count = (height - 1) * step + width * channels - size + 1
    at_byte = as_strided(picture, (count, size), (1, 1), writeable=False).view(f'V{size}')[:, 0]
    pixels = at_byte[words * size + words // per_row * (step - per_row * size)]
    return pixels.view(np.uint8).reshape(1, -1, channels)
