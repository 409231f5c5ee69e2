"""Labels YUV pictures, converting only the pixels that may have a color.

Two or four pixels share their chroma, U and V. Most of a picture has a chroma that none of the
colors has with any luma. One lookup per chroma sample, with 16 bits of the picture as they are,
rules it out. The remaining pixels are converted and labeled. The result equals that of converting
the whole picture first, to the bit.
"""

from collections.abc import Callable
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.detection.color_table import look_up
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.label_image import WORD
from colortrack_ros.detection.survivors import PICTURES_OF_PAUSE
from colortrack_ros.encodings import size_of
from colortrack_ros.encodings import to_bgr
from colortrack_ros.encodings import YUV422

Label = Callable[[NDArray[np.uint8]], NDArray[np.uint8]]
"""Returns (H, W) labels of a bgr8 picture, (H, W, 3)."""

CHROMA_STEP = 4
"""Levels of Y, U and V that are grouped to build the chroma table. Assumed: with 2, building it
takes eight times as long; with 8, CELL_DILATION doubles."""

CELL_DILATION = (1, 2, 1)
"""Cells of red, green and blue by which the color in the middle of CHROMA_STEP^3 levels may be off
from any of theirs: by BT.601 they differ by at most 5.2, 4.6, 5.8 levels."""

NEARLY_GRAY = slice(112, 144)
"""U and V of most of a picture, within 1/8 of their range. Assumed; it affects only the time, since
it only selects which of the two to test first."""

CONVERTED_SHARE = 0.25
"""Largest share of the chroma samples for which converting single pixels pays. It affects only the
time, which `python benchmark/detection.py` measures."""


@lru_cache(maxsize=1)
def _cells() -> NDArray[np.intp]:
    """(64 U, 64 V, 60 Y) cell in the middle of CHROMA_STEP^3 levels, by ITU-R BT.601."""
    chroma = np.arange((CHROMA_STEP - 1) / 2, 256, CHROMA_STEP) - 128
    luma = 1.164 * (np.arange(16 + (CHROMA_STEP - 1) / 2, 256, CHROMA_STEP) - 16)
    u, v, y = np.meshgrid(chroma, chroma, luma, indexing='ij', sparse=True)
    rgb = y + 1.596 * v + 0 * u, y - 0.391 * u - 0.813 * v, y + 2.018 * u + 0 * v
    red, green, blue = (np.clip(np.rint(c), 0, 255).astype(np.intp) for c in rgb)
    return np.asarray(red >> 3 << 11 | green >> 2 << 5 | blue >> 3)


def _dilated(touched: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(65536,) the cells and their neighbors, by CELL_DILATION."""
    cells = touched.reshape(32, 64, 32)
    for axis, reach in enumerate(CELL_DILATION):
        one = np.moveaxis(cells, axis, 0)
        wide = one.copy()
        for k in range(1, reach + 1):
            wide[k:] |= one[:-k]
            wide[:-k] |= one[k:]
        cells = np.moveaxis(wide, 0, axis)
    return cells.reshape(-1)


class ChromaFilter:
    """Finds which chroma may belong to a color, with any luma.

    :param touched: (65536,) which cells of 5, 6 and 5 bits contain any part of a color.
    """

    def __init__(self, touched: NDArray[np.bool_]) -> None:
        may = _dilated(touched)[_cells()].any(axis=2)
        table = np.kron(may, np.ones((CHROMA_STEP, CHROMA_STEP), bool)).astype(np.uint8)
        # The first byte in the picture is the low byte of the number.
        self._v_first, self._u_first = table.reshape(-1), table.T.reshape(-1)
        # Of U and V alone, use the one that better separates near-gray from the colors.
        alone = table.max(axis=1), table.max(axis=0)
        self._better = int(np.argmin([one[NEARLY_GRAY].sum() for one in alone]))
        self._alone = alone[self._better]
        first, behind = self._alone.argmax(), len(self._alone) - self._alone[::-1].argmax()
        self._range = int(first), int(behind) - 1
        self._chroma: NDArray = np.empty((0, 0), np.uint8)
        self._pause = 0

    def label(self, frame: Frame, label: Label, old: LabelImage | None = None) -> LabelImage | None:
        """Label a YUV picture; None if converting all of it is faster.

        :param label: labels the converted pixels.
        :param old: an image that is no longer needed.
        """
        if self._pause:
            self._pause -= 1
            return None
        may = (self._may_have if frame.encoding in YUV422 else self._plane_may_have)(frame)
        (words,) = (may.words != 0).nonzero()
        if WORD * len(words) > CONVERTED_SHARE * may.pixels.size:
            self._pause = PICTURES_OF_PAUSE
            return None
        image = LabelImage.blank(*size_of(frame), old)
        image.filled = words[:0]
        if len(words):
            row, word = np.divmod(words, may.stride // WORD)
            column = (WORD * word[:, None] + np.arange(WORD)).reshape(-1)
            pixels = (_pairs if frame.encoding in YUV422 else _quadruples)(
                frame, row.repeat(WORD), column
            )
            _write(image, label(to_bgr(pixels, frame.encoding)).view(np.uint64), row, word)
        return image

    def _may_have(self, frame: Frame) -> LabelImage:
        """(H, W / 2) nonzero if U or V (the better one) of yuyv or uyvy may belong to a color."""
        height, width = size_of(frame)
        may = LabelImage.empty(height, width // 2)
        channel = 2 * self._better + (frame.encoding == 'yuyv')
        pairs = frame.image.reshape(height, width // 2, 4)
        # Reuse the memory of the last picture: fresh pages cost as much as the work itself.
        self._chroma = cv2.extractChannel(pairs, channel, dst=self._chroma)
        low, high = self._range
        if self._alone[low : high + 1].all():
            cv2.inRange(self._chroma, low, high, dst=may.pixels)
        else:
            cv2.LUT(self._chroma, self._alone, dst=may.pixels)
        return may

    def _plane_may_have(self, frame: Frame) -> LabelImage:
        """(H / 2, W / 2) nonzero if U and V of nv12 or nv21 may belong to a color."""
        chroma = frame.image[size_of(frame)[0] :].view(np.uint16)
        may = LabelImage.empty(*chroma.shape)
        look_up(self._v_first if frame.encoding == 'nv21' else self._u_first, chroma, may.pixels)
        return may


def _pairs(frame: Frame, row: NDArray[np.intp], column: NDArray[np.intp]) -> NDArray[np.uint8]:
    """(1, 2 N, 2) pairs of pixels that share their chroma, as a yuyv or uyvy picture.

    What is past the end of a row is of the next row, or the last pixels.
    """
    width = frame.image.shape[1]
    words = np.ascontiguousarray(frame.image).reshape(-1).view(np.uint32)
    taken = words.take(row * (width // 2) + column, mode='clip')
    return taken.view(np.uint8).reshape(1, -1, 2)


def _quadruples(frame: Frame, row: NDArray[np.intp], column: NDArray[np.intp]) -> NDArray[np.uint8]:
    """(3, 2 N) 2x2 pixels that share their chroma, as an nv12 or nv21 picture; as _pairs."""
    height, width = size_of(frame)
    words = np.ascontiguousarray(frame.image).reshape(-1).view(np.uint16)
    line = width // 2
    first = 2 * row * line + column
    taken = [first, first + line, (height + row) * line + column]
    return words.take(np.stack(taken), mode='clip').view(np.uint8)


def _write(
    image: LabelImage, labels: NDArray[np.uint64], row: NDArray[np.intp], word: NDArray[np.intp]
) -> None:
    """Write the labels of the pixels of N words of chroma samples, in place.

    :param labels: (rows, 2 N) words.
    :param row, word: (N,) of the chroma, in raster order.
    """
    rows, per_row = len(labels), image.stride // WORD
    line = (rows * row[:, None] + np.arange(rows)) * per_row
    target = np.ravel((line + 2 * word[:, None])[:, :, None] + np.arange(2))
    labels = labels.reshape(rows, -1, 2).transpose(1, 0, 2).reshape(-1)
    if 2 * word.max() + 1 == per_row:  # past the end of a row
        is_inside = (2 * word[:, None] + np.arange(2) < per_row).repeat(rows, axis=0).reshape(-1)
        target, labels = target[is_inside], labels[is_inside]
    image.words[target] = labels
    image.padded[:, image.width :] = 0
    image.filled = target if rows == 1 else np.sort(target)
