"""Labels only the part of a picture that can survive an erosion.

A pixel survives an erosion with a square of side s only if it is at the center of s labeled rows of
s labeled pixels. One of these pixels is on the grid of every s-th pixel of every s-th row. The grid
is labeled first, and then, word by word, the pixels near its labels. Most of a picture need not be
labeled.
"""

from collections.abc import Callable
from functools import lru_cache

import cv2
import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.label_image import WORD

LABELED_SHARE = 0.25
"""Largest share of the picture to label word by word; above it, labeling everything is as fast. The
constants of this file affect only the time, which `python benchmark/detection.py` measures."""

WORTHWHILE_PIXELS = 1 << 18, 1 << 19
"""Least number of pixels for which it pays; the latter with what is connected to survivors, where
OpenCV looks labels up: in smaller pictures, labeling everything is as fast."""

PICTURES_OF_PAUSE = 16
"""Number of pictures before another attempt after the share was too large. Assumed: one attempt in
16 costs little, and half a second at 30 Hz is soon enough."""

LabelRows = Callable[[NDArray[np.uint8]], LabelImage]
"""Returns the labels of some rows of the picture."""

LabelPixels = Callable[[NDArray[np.uint8]], tuple[LabelImage, NDArray[np.intp]]]
"""Returns the labels of pixels, (H, W, channels) or (H, W, 4), and the words that are not empty."""


class Survivors:
    """Labels everything that survives an erosion.

    :param connected: whether to label all pixels connected to survivors too, whatever their labels.
    :param cheap: whether OpenCV looks labels up, which is several times faster than NumPy.
    """

    def __init__(self, connected: bool, cheap: bool) -> None:
        self._connected, self._cheap = connected, cheap
        self._pause = self._dense = 0

    def label(
        self,
        picture: NDArray[np.uint8],
        size: int,
        label_rows: LabelRows,
        label_pixels: LabelPixels,
        old: LabelImage | None = None,
    ) -> LabelImage | None:
        """Label the survivors; None if labeling the whole picture is as fast.

        :param picture: (H, W, channels).
        :param size: side of the square, odd [px].
        :param old: an image that is no longer needed.
        """
        height, width = picture.shape[:2]
        self._pause = max(self._pause - 1, 0)
        least = WORTHWHILE_PIXELS[self._connected and self._cheap]
        if size == 1 or height * width < least or self._pause:
            return None
        if height < 2 * size or width < max(size, WORD):
            return None
        step, pixel = picture.strides[0], picture.shape[2]
        if picture.strides[1:] != (pixel, 1) or step < 0:
            return None
        image = LabelImage.blank(height, width, old)
        near = self._near(picture, size, label_rows, label_pixels)
        words = _words_near(near, size)
        if not self._label_words(image, picture, words, size, label_pixels):
            self._pause = PICTURES_OF_PAUSE
            return None
        return image

    def _near(
        self,
        picture: NDArray[np.uint8],
        size: int,
        label_rows: LabelRows,
        label_pixels: LabelPixels,
    ) -> NDArray[np.bool_]:
        """(H, words of a row) whether a square around a label of every size-th row may reach a
        word: by the grid or, while that leaves too many, by runs of labels.
        """
        self._dense = max(self._dense - 1, 0)
        if not self._dense:
            near = _near_grid(*label_pixels(_grid_of(picture, size)), size, picture.shape[1])
            if np.count_nonzero(near) <= LABELED_SHARE / 2 * near.size:
                return near
            self._dense = PICTURES_OF_PAUSE
        return _near_runs(label_rows(picture[size // 2 :: size]), size)

    def _label_words(
        self,
        image: LabelImage,
        picture: NDArray[np.uint8],
        words: NDArray[np.intp],
        size: int,
        label_pixels: LabelPixels,
    ) -> bool:
        """Label words, and all of the last rows, in place; False if there are too many."""
        count, below = len(image.words), image.stride // WORD
        first = count - size * below
        words = words[: words.searchsorted(first)]
        # Reading words extends into the row below.
        bottom, filled = label_pixels(picture[-size:])
        image.words[first:] = bottom.words
        filled = filled + first
        known = np.zeros(count + 2 * (below + 1), bool)
        known[: below + 1] = known[first + below + 1 :] = True
        labeled = 0
        while len(words):
            is_first, labeled = labeled == 0, labeled + len(words)
            if labeled > LABELED_SHARE * count:
                return False
            block, found = label_pixels(_pixels_of(picture, words))
            image.words[words] = block.words[:-1]
            image.padded[:, image.width :] = 0
            found = words[found]
            filled = np.concatenate([found, filled])
            if not self._connected:
                break
            known[words + (below + 1)] = True
            seen = _at_unknown(filled, known, below) if is_first else found
            words = _words_beside(image, seen, known) if len(seen) else seen
        filled.sort(kind='stable')  # a merge of few ascending parts
        image.filled = filled
        return True


def _grid_of(picture: NDArray[np.uint8], size: int) -> NDArray[np.uint8]:
    """(H, W, 4) the pixels of the grid; the last row is left out, since it is labeled anyway.

    A fourth channel may be that of the next pixel: four bytes are copied faster than three.
    """
    half, (row, pixel, _) = size // 2, picture.strides
    shape = len(picture[half:-1:size]), len(picture[0, half::size])
    strides = size * row, size * pixel
    grid = np.ndarray(shape, np.uint32, _bytes_of(picture), half * (row + pixel), strides)
    return grid.copy().view(np.uint8).reshape(*shape, 4)


def _words_near(near: NDArray[np.bool_], size: int) -> NDArray[np.intp]:
    """Ascending indices of words that may contain survivors; some are below the picture.

    :param near: (H, words of a row) for every size-th row; any square contains one of them.
    """
    # A square in the rows up to a sampled one contains that row or the previous sampled one.
    near[1:] |= near[:-1].copy()
    return np.flatnonzero(near.repeat(size, axis=0)[size - 1 - size // 2 :])


def _near_grid(
    grid: LabelImage, filled: NDArray[np.intp], size: int, width: int
) -> NDArray[np.bool_]:
    """(H, words of a row) whether a square around a label of the grid may reach a word.

    :param grid: labels of every size-th column.
    :param filled: the words of the grid that are not empty.
    :param width: of the picture [px].
    """
    half, count = size // 2, grid.width
    near = np.zeros((len(grid.padded), width // WORD + 1), bool)
    if filled.size:
        has_label = np.zeros(len(near), bool)
        has_label[filled // (grid.stride // WORD)] = True
        (row,) = has_label.nonzero()
        reached = grid.padded.take(row, axis=0)
        flat = reached.reshape(-1)
        flat[:-1] |= flat[1:]
        flat[:-2] |= flat[2:]
        near[row] = reached.take(_reaching(near.shape[1], count, size), axis=1)
    behind = count * size - half
    if behind < width - half:
        near[:, behind // WORD :] = True  # squares at the border that are right of the grid
    return near


@lru_cache(maxsize=4)
def _reaching(words: int, count: int, size: int) -> NDArray[np.intp]:
    """First of the columns of the grid, four at most, from which each word may be reached."""
    return ((np.arange(words) * WORD - size // 2) // size).clip(0, count - 1)


def _near_runs(sampled: LabelImage, size: int) -> NDArray[np.bool_]:
    """(H, words of a row) whether a word has a run of labels that is as long as the square.

    :param sampled: labels of every size-th row.
    """
    opened = LabelImage.empty(*sampled.pixels.shape)
    along = np.ones((1, size), np.uint8)
    cv2.morphologyEx(sampled.pixels, cv2.MORPH_OPEN, along, dst=opened.pixels)
    return (opened.words != 0).reshape(len(sampled.padded), -1)


def _at_unknown(words: NDArray[np.intp], known: NDArray[np.bool_], below: int) -> NDArray[np.intp]:
    """The words with unknown ones around them; known is as in _words_beside."""
    beside = known[:-2] & known[1:-1]
    beside &= known[2:]
    around = beside[: -2 * below] & beside[below:-below]
    around &= beside[2 * below :]
    return words[~around.take(words)]


def _words_beside(
    image: LabelImage, words: NDArray[np.intp], known: NDArray[np.bool_]
) -> NDArray[np.intp]:
    """Ascending indices of unknown words that may be connected to the pixels of given ones.

    :param known: which words are known, padded by one row and one word before the first and after
        the last.
    """
    below = image.stride // WORD
    labels = image.words.take(words)
    pixels = labels.view(np.uint8).reshape(-1, WORD)
    rows = np.array([[-below], [0], [below]])
    ways = (
        words[labels != 0] + rows[::2],
        words[pixels[:, 0] != 0] + (rows - 1),
        words[pixels[:, -1] != 0] + (rows + 1),
    )
    beside = np.concatenate([way.reshape(-1) for way in ways])
    beside = beside[~known.take(beside + (below + 1))]
    beside.sort()
    is_first = np.ones(len(beside), bool)
    np.not_equal(beside[1:], beside[:-1], out=is_first[1:])
    return beside[is_first]


def _pixels_of(picture: NDArray[np.uint8], words: NDArray[np.intp]) -> NDArray[np.uint8]:
    """(1, 8 N, channels) the pixels of words; the last word of a row also reads from the next row.

    :param picture: (H, W, channels).
    :param words: (N,) indices in its label image, none in the last row.
    """
    _, width, channels = picture.shape
    step, size, per_row = picture.strides[0], WORD * channels, width // WORD + 1
    content = _bytes_of(picture)
    at_byte = np.ndarray(content.size - size + 1, f'V{size}', content, strides=(1,))
    pixels = at_byte[words * size + words // per_row * (step - per_row * size)]
    return pixels.view(np.uint8).reshape(1, -1, channels)


def _bytes_of(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """All bytes from the first pixel to the last, with the padding of rows; a view."""
    if picture.flags.c_contiguous:
        return picture.reshape(-1)
    count = (len(picture) - 1) * picture.strides[0] + picture[0].size
    return as_strided(picture, (count,), (1,), writeable=False)
