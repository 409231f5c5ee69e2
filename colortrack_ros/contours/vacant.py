"""Contours of nothing: the foreground does not fill them, or is a place that something has left."""

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.areas import Mask
from colortrack_ros.contours.background import CROSS
from colortrack_ros.contours.background import edges_at
from colortrack_ros.contours.background import softened
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.detection.background_model import Picture

LEAST_FILLED = 0.1
"""Least share of its outline that is foreground: regions.LEAST_OVERLAP, with which a target takes
part of somebody else's area for its own. Of ten clips 78 false rows of 610 have less and 6 of 2,587
right ones, 59 and 1 with half, 122 and 30 with twice the value (benchmark/notes/contours.md)."""

LEFT_EDGES = 2.0
"""Ratio of the edges around a foreground, in the background over those in the picture, from which
it is a place that something has left. Of the same clips 46 false rows and no right one have more;
with 1.5 of it 78 and 23, with 3 of it 15 and 0."""

MARGIN_PIXELS = 2
"""Foreground this near to an outline belongs to it [px]: the rim that the Gaussian adds
(foreground.RIM_SHARE)."""

MARGIN_SQUARE = np.ones((2 * MARGIN_PIXELS + 1, 2 * MARGIN_PIXELS + 1), np.uint8)
"""That around a pixel."""

FILTER_PIXELS = 2
"""Reach of the edges of softened pictures, both 3x3, and of MARGIN_SQUARE [px]."""


def is_vacant(outlines: Floats, mask: Mask, picture: Picture, background: Picture) -> Bools:
    """Return which outlines, (N, P, 2) [px], are of nothing, (N,).

    A thing has edges around it in the picture, a place that one has left in the background.

    :param mask: (H, W), not 0 where the picture differs from the background.
    :param picture: (H, W, channels).
    :param background: of the same shape.
    """
    vacant, reach = np.ones(len(outlines), bool), MARGIN_PIXELS + FILTER_PIXELS
    low = np.maximum(_whole(outlines.min(axis=1)) - reach, 0)
    high = np.minimum(_whole(outlines.max(axis=1)) + reach + 1, mask.shape[::-1])
    within = (high > low).all(axis=1)
    if within.any():
        strip = _Strip(low[within], high[within], mask.size)
        vacant[within] = strip.shows_nothing(outlines[within], mask, (picture, background))
    return vacant


class _Strip:
    """Cells around targets, one below the other, so that each filter runs once for all of them.

    :param low: left and top of the cells, (N, 2), inside the picture [px].
    :param high: right and bottom, likewise, exclusive, and above low.
    :param size: of the picture [px].
    """

    def __init__(self, low: Indices, high: Indices, size: int) -> None:
        self._low, (width, height) = low, (high - low).T
        self._from = [np.s_[y:v, x:u] for (x, y), (u, v) in np.stack([low, high], 1).tolist()]
        last = np.cumsum(height + 2 * FILTER_PIXELS)
        self._top = last - height - FILTER_PIXELS
        self._shape = int(last[-1]), int(width.max()) + 2 * FILTER_PIXELS
        ends = np.stack([self._top, self._top + height, FILTER_PIXELS + width], 1).tolist()
        self._cells = [np.s_[top:bottom, FILTER_PIXELS:right] for top, bottom, right in ends]
        self._is_small = self._shape[0] * self._shape[1] < size

    def shows_nothing(
        self, outlines: Floats, mask: Mask, pictures: tuple[Picture, Picture]
    ) -> Bools:
        """Return which outlines, (N, P, 2), are of nothing, (N,).

        :param mask: see is_vacant.
        :param pictures: the picture and the background.
        """
        differs, inside = np.zeros((2, *self._shape), np.uint8)
        beyond = np.ones(self._shape, np.uint8)
        polygons = (_whole(outlines) - self._low[:, None]).astype(np.int32)
        for here, cell, polygon in zip(self._from, self._cells, polygons, strict=True):
            differs[cell], beyond[cell] = mask[here], 0
            cv2.fillPoly(inside[cell], [polygon], 1)
        np.minimum(differs, 1, out=differs)
        filled = self._counts(differs & inside)
        nothing = (filled == 0) | (filled < LEAST_FILLED * self._counts(inside))
        own = np.minimum(differs, cv2.dilate(inside, MARGIN_SQUARE))
        rest = cv2.erode(np.maximum(own, beyond), CROSS)
        rim = np.divmod(np.flatnonzero(own > rest), own.shape[1])
        whose = np.searchsorted(self._top, rim[0], side='right') - 1
        edges = (self._edges_at(rim, whose, each) for each in pictures)
        now, before = (np.bincount(whose, each, len(outlines)) for each in edges)
        return np.asarray(nothing | (before > LEFT_EDGES * now))

    def _edges_at(
        self, rim: tuple[Indices, Indices], whose: Indices, picture: Picture
    ) -> NDArray[np.int64]:
        """Return the edges in a picture, (n,) [levels].

        The filters run over the smaller of the two, strip and picture.

        :param rim: rows and columns of the strip, (n,).
        :param whose: cells in which they are, (n,).
        """
        if not self._is_small:
            left, top = self._low[whose].T
            there = rim[0] - self._top[whose] + top, rim[1] - FILTER_PIXELS + left
            return edges_at(softened(picture), there)
        sides = (FILTER_PIXELS,) * 4
        laid = np.zeros((*self._shape, picture.shape[2]), np.uint8)
        for here, (rows, columns) in zip(self._from, self._cells, strict=True):
            framed = laid[rows.start - FILTER_PIXELS :, : columns.stop + FILTER_PIXELS]
            part = cv2.copyMakeBorder(picture[here], *sides, cv2.BORDER_REFLECT_101)
            framed[: len(part)] = part.reshape(*part.shape[:2], -1)
        return edges_at(softened(laid), rim)

    def _counts(self, ones: Mask) -> Indices:
        """Return the number of pixels of each cell that are 1, (N,)."""
        rows = cv2.reduce(ones, 1, cv2.REDUCE_SUM, dtype=cv2.CV_32S)[:, 0]
        return np.add.reduceat(rows, self._top)


def _whole(points: Floats) -> Indices:
    return np.rint(points).astype(np.intp)
