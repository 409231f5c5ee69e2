"""Color histograms of a target and of its surroundings."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
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
        part = np.where(outward > OUTER, 1, np.where(outward <= INNER, 0, 2)).ravel()  # 2: either
        self._pixels = np.maximum(np.bincount(part, minlength=3)[:2, None], 1)
        self._first_bin = part * LEVELS ** (3 if patch.ndim == 3 else 1)
        counts = self._counts(patch)
        self._seen: Bools = np.asarray(counts.any(axis=0))
        self._shares = counts / self._pixels
        self._table = np.full(len(self._seen), 0.5, np.float32)
        self._renew_table(np.flatnonzero(self._seen))

    def learn(self, patch: Pixels) -> None:
        """Update the histograms from a patch with the target in the middle."""
        counts = self._counts(patch)
        self._seen |= counts.any(axis=0)
        seen = np.flatnonzero(self._seen)  # a few hundred of 32,768
        before = self._shares[:, seen]
        self._shares[:, seen] = before + COLOR_RATE * (counts[:, seen] / self._pixels - before)
        self._renew_table(seen)

    def likelihood(self, patch: Pixels) -> Features:
        """Return the probability, (rows, columns), that a pixel is the target's by its color."""
        return np.asarray(self._table.take(_index(patch)))

    def _renew_table(self, seen: Indices) -> None:
        """Recompute the probabilities of the bins that have been seen."""
        target, beside = self._shares[:, seen]
        both = target + beside
        half = np.full(len(seen), 0.5)
        self._table[seen] = np.divide(target, both, out=half, where=both > 0)

    def _counts(self, patch: Pixels) -> Indices:
        """Count the pixels of each color, target and surroundings: (2, LEVELS ** channels)."""
        count = LEVELS ** (3 if patch.ndim == 3 else 1)
        bins = _index(patch).ravel() + self._first_bin
        return np.bincount(bins, minlength=3 * count).reshape(3, count)[:2]


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
