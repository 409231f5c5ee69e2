"""Finds the columns of a strip of the picture that may contain a color.

Where the lookup in a table of 2^16 entries is slow (OpenCV 4), most pixels can skip it. Red
objects, for example, have far more red than green: the difference of two channels and the maximum
of each column rule out most of the picture. The result is the same to the bit. The constants below
affect only the time, which `python benchmark/detection.py` measures.
"""

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.pixels import RED_FIRST

CONTRASTS = ((0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1), (1, None), (None, 1))
"""Channel minus channel, red 0, green 1, blue 2; with None, green alone, or its darkness."""

GRAY_RANGE = 64
"""Largest difference of the channels [levels] in most of a picture. Assumed; like the constants
that follow, it affects only the time: half and twice of each give the same masks."""

JOIN_PIXELS = 8192
"""Number of pixels between two candidates that are looked up with them: a second call costs as
much."""

WORTHWHILE_SHARE = 0.5
"""Largest share of columns that may remain for the filter to be worth its own time. Assumed."""

SHARE_STRIPS = 16
"""Number of strips over which the share is averaged; while it is too large, one in this many is
filtered. Assumed: that costs 1/16 of the filter's time, and once the color has left, the share
falls below WORTHWHILE_SHARE after 11 tries, 176 strips: 22 pictures of 1920x1080."""


@lru_cache(maxsize=1)
def _ranges() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Least measures of each cell, (8, 65536), and number of gray cells that reach a value, (8,
    256).
    """
    cell = np.arange(1 << 16)
    low = np.stack([cell >> 11 << 3, (cell >> 5 & 63) << 2, (cell & 31) << 3])
    high = low + np.array([[7], [3], [7]])
    gray = np.ptp(low, axis=0) <= GRAY_RANGE
    least, reached = [], []
    for plus, minus in CONTRASTS:
        first = (255, 255) if plus is None else (low[plus], high[plus])
        second = (0, 0) if minus is None else (low[minus], high[minus])
        least.append(np.broadcast_to(np.maximum(first[0] - second[1], 0), cell.shape))
        most = np.maximum(first[1] - second[0], 0)[gray]
        reached.append(np.bincount(most, minlength=256)[::-1].cumsum()[::-1])
    return np.array(least), np.array(reached)


class ColumnFilter:
    """Selects, for each color, the measure that rules out the most gray.

    :param touched: (colors, 65536) which cells of 5, 6 and 5 bits contain any part of a color.
    """

    def __init__(self, touched: NDArray[np.bool_]) -> None:
        least, reached = _ranges()
        self._least: dict[tuple[int | None, int | None], int] = {}
        for cells in touched:
            bound = least[:, cells].min(axis=1, initial=255)
            k = reached[np.arange(len(CONTRASTS)), bound].argmin()
            self._least[CONTRASTS[k]] = min(int(bound[k]), self._least.get(CONTRASTS[k], 255))
        self._turn, self._share = 0, 0.0

    def parts(self, picture: NDArray[np.uint8], encoding: str) -> list[tuple[int, int]]:
        """First column and one past the last of each part that may contain a color.

        If nearly all columns may, most strips are not analyzed, and returned as one part.

        :param picture: (H, W, channels), not mono8.
        """
        self._turn += 1
        if self._share > WORTHWHILE_SHARE and self._turn % SHARE_STRIPS:
            return [(0, picture.shape[1])]
        parts = self._find(picture, encoding)
        share = sum(right - left for left, right in parts) / picture.shape[1]
        self._share += (share - self._share) / SHARE_STRIPS
        return parts

    def _find(self, picture: NDArray[np.uint8], encoding: str) -> list[tuple[int, int]]:
        order = (0, 1, 2) if encoding in RED_FIRST else (2, 1, 0)
        used = {k for measure in self._least for k in measure}
        channel: dict[int | None, NDArray] = {
            k: cv2.extractChannel(picture, order[k]) for k in range(3) if k in used
        }
        may = np.zeros(picture.shape[1], bool)
        for (plus, minus), least in self._least.items():
            if plus is None:
                value = cv2.bitwise_not(channel[minus])
            else:
                value = channel[plus]
                value = value if minus is None else cv2.subtract(value, channel[minus])
            may |= value.max(axis=0) >= least
        column = np.flatnonzero(may)
        if not len(column):
            return []
        apart = np.flatnonzero(np.diff(column) > JOIN_PIXELS // len(picture))
        left, right = np.append(column[0], column[apart + 1]), np.append(column[apart], column[-1])
        return list(zip(left.tolist(), (right + 1).tolist(), strict=True))
