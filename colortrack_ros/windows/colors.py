"""Which colors are the target's, and which are beside it."""

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.windows.features import Features
from colortrack_ros.windows.features import Floats
from colortrack_ros.windows.features import Pixels

LEVELS = 32
"""Of each channel in a histogram (Bertinetto et al. 2016, table 1), as is the rate of learning."""
COLOR_RATE = 0.04

INNER, OUTER = 0.8, 1.1
"""A pixel is the target's inside this share of its box, as in Staple (inner padding of 0.2), and
of what is beside it outside this one: what is between is either."""


class Colors:
    """Histograms of the colors of a target, and of those around it (Possegger et al. 2015).

    :param patch: (rows, columns) or (rows, columns, 3) with the target in the middle.
    :param target: its width and height [px of the patch].
    """

    def __init__(self, patch: Pixels, target: Floats) -> None:
        rows, columns = patch.shape[:2]
        v = np.abs(np.arange(rows) - (rows - 1) / 2)[:, None] / target[1]
        u = np.abs(np.arange(columns) - (columns - 1) / 2) / target[0]
        outward = 2 * np.maximum(u, v)
        self._inside, self._outside = outward <= INNER, outward > OUTER
        self._target, self._beside = self._histograms(patch)
        self._table = self._likelihoods()

    def learn(self, patch: Pixels) -> None:
        """Learn the colors of a patch with the target in the middle."""
        target, beside = self._histograms(patch)
        self._target += COLOR_RATE * (target - self._target)
        self._beside += COLOR_RATE * (beside - self._beside)
        self._table = self._likelihoods()

    def likelihood(self, patch: Pixels) -> Features:
        """Probability of each pixel to be the target's by its color, (rows, columns)."""
        return np.asarray(self._table[_index(patch)])

    def _likelihoods(self) -> Features:
        both = self._target + self._beside
        known = both > 0
        return np.where(known, self._target / np.where(known, both, 1), 0.5).astype(np.float32)

    def _histograms(self, patch: Pixels) -> tuple[Floats, Floats]:
        index = _index(patch)
        count = LEVELS ** (3 if patch.ndim == 3 else 1)
        pair = (
            np.bincount(index[where], minlength=count) for where in (self._inside, self._outside)
        )
        target, beside = (bins / max(bins.sum(), 1) for bins in pair)
        return target, beside


def mean_inside(likelihood: Features, size: tuple[int, int], target: Floats) -> Features:
    """Mean likelihood of a box of the target's size around each cell.

    :param size: columns and rows of cells that are wanted.
    :param target: width and height of the box [cells].
    """
    cells = cv2.resize(likelihood, size, interpolation=cv2.INTER_AREA)
    box = np.rint(target).astype(int) | 1
    return np.asarray(cv2.blur(cells, tuple(box.tolist()), borderType=cv2.BORDER_REPLICATE))


def _index(patch: Pixels) -> NDArray[np.intp]:
    levels = (patch // (256 // LEVELS)).astype(np.intp)
    if levels.ndim == 2:
        return levels
    return (levels[..., 0] * LEVELS + levels[..., 1]) * LEVELS + levels[..., 2]
