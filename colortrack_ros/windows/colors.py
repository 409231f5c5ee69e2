"""Color histograms of a target and of its surroundings."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.windows.features import Features
from colortrack_ros.windows.features import Pixels

LEVELS, COLOR_RATE = 32, 0.04
"""Levels of each channel in a histogram, and learning rate (Bertinetto et al. 2016, table 1)."""

INNER, OUTER = 0.8, 1.1
"""Pixels inside the first share of the box belong to the target (Staple's inner padding of 0.2),
pixels outside the second to its surroundings. Those in between may be either and are ignored. The
second is assumed: larger ones ignore more of a loose box's margin, and learn less around it."""


class Colors:
    """Color histograms of a target and of its surroundings (Possegger et al. 2015).

    :param patch: (rows, columns) or (rows, columns, 3) with the target in the middle.
    :param target: its width and height [px of the patch].
    """

    def __init__(self, patch: Pixels, target: Floats) -> None:
        rows, columns = patch.shape[:2]
        v = np.abs(np.arange(rows) - (rows - 1) / 2)[:, None] / target[1]
        u = np.abs(np.arange(columns) - (columns - 1) / 2) / target[0]
        outward = 2 * np.maximum(u, v)
        part = np.where(outward > OUTER, 1, np.where(outward <= INNER, 0, 2))  # 2: either
        self._part = part.ravel()
        self._pixels = np.maximum(np.bincount(self._part, minlength=3)[:2, None], 1)
        count = LEVELS ** (3 if patch.ndim == 3 else 1)
        self._column, self._seen = np.full(count, -1), np.zeros(0, np.intp)
        self._shares, self._table = np.zeros((2, 0)), np.full(count, 0.5, np.float32)
        counts = self._counts(patch)
        self._shares[:] = counts / self._pixels
        self._renew_table()

    def learn(self, patch: Pixels) -> None:
        """Update the histograms from a patch with the target in the middle."""
        counts = self._counts(patch)
        self._shares += COLOR_RATE * (counts / self._pixels - self._shares)
        self._renew_table()

    def likelihood(self, patch: Pixels) -> Features:
        """Return the probability, (rows, columns), that a pixel is the target's by its color."""
        return np.asarray(self._table.take(_index(patch)))

    def _renew_table(self) -> None:
        """Recompute the probabilities of the bins that have been seen."""
        target, beside = self._shares
        both = target + beside
        half = np.full(len(both), 0.5)
        self._table[self._seen] = np.divide(target, both, out=half, where=both > 0)

    def _counts(self, patch: Pixels) -> Indices:
        """Count the pixels of each color that has been seen, target and surroundings: (2, n).

        These are a few hundred of 32,768. New ones are added.
        """
        bins = _index(patch).ravel()
        columns = self._column.take(bins)
        if (new := np.unique(bins[columns < 0])).size:
            self._column[new] = len(self._seen) + np.arange(len(new))
            self._seen = np.concatenate([self._seen, new])
            self._shares = np.pad(self._shares, ((0, 0), (0, len(new))))
            columns = self._column.take(bins)
        count = len(self._seen)
        both = np.bincount(columns + count * self._part, minlength=3 * count)
        return both.reshape(3, count)[:2]


def mean_inside(likelihood: Features, size: tuple[int, int], target: Floats) -> Features:
    """Return the mean likelihood in a box of the target's size around each cell.

    :param size: columns and rows of the result [cells].
    :param target: width and height of the box [cells].
    """
    cells = cv2.resize(likelihood, size, interpolation=cv2.INTER_AREA)
    box = np.rint(target).astype(int) | 1
    return np.asarray(cv2.blur(cells, tuple(box.tolist()), borderType=cv2.BORDER_REPLICATE))


def _index(patch: Pixels) -> NDArray[np.integer[Any]]:
    """Return the bin of each pixel, (rows, columns): the upper five bits of each channel."""
    if patch.ndim == 2:
        return patch // (256 // LEVELS)
    return cv2.cvtColor(patch, cv2.COLOR_BGR2BGR555).view(np.uint16)[..., 0]
