"""Usual areas: which blobs are objects, and which are pieces of one, or specks."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.claims import hold_several
from colortrack_ros.detection.extent import LARGEST_SHARE
from colortrack_ros.detection.shape import aspect
from colortrack_ros.detection.touching import Things
from colortrack_ros.encodings import size_of

# Unless noted otherwise, the constants below were chosen. On four real clips, `python
# benchmark/colors.py --constants` halves and doubles them.

USUAL_SECONDS = 3.0
"""Memory for the usual area of a blob: it is forgotten after at most this time, and at least half
of it [s]. Longer than a hand or a turn hides most of an object, and shorter than it takes to walk
away from the camera."""

CROWD_SHARE = 1 / 3
"""Share of the pixels of a color in blobs of at most the usual area. Pieces of an object have fewer
of them; in a crowd, the objects that touch nobody have more. Assumed."""

LEAST_SHARE, PIECE_SHARE = 1 / 20, 1 / 3
"""Least area over the usual one, anywhere, and right beside a larger blob. The first keeps objects
at 4.5 times the distance, but no glints. The second drops pieces that a stripe or a finger cuts
off, up to a third. Equal objects right beside each other, if they are no discs, are assumed to
differ in distance by less than a factor of 1.7. Assumed."""

MOST_SUDDEN = 4.0
"""Area over the usual one from which on a blob over more of the picture than a color may cover is
no object, but a wall in passing, a flash, or darkness, unless it stays for USUAL_SECONDS. Assumed:
none gets twice as wide at once."""

PIECE_REACH = 0.5
"""Margin around the box of a blob in which its pieces lie [share of the side of the box].
Assumed."""


DISC_FILLED, DISC_ASPECT, DISC_PIXELS = 0.97, 0.8, 64
"""Area over that of the ellipse with the same moments, ratio of its axes, and area [px] of a disc,
which no cut leaves: half a disc and a rectangle fill 0.95 of theirs. Smaller blobs have no shape.
Chosen."""


class UsualAreas:
    """Learns the area of one object of each color whose tolerance is estimated.

    :param count: number of colors.
    :param sought: indices of these; blobs of all others are kept.
    """

    def __init__(self, count: int, sought: list[int]) -> None:
        self._sought = sought
        self._usual = np.zeros((2, count))
        self._measured = 0
        self._unfilled = np.zeros(count, np.int64)
        """Last picture that each color did not suddenly fill [ns]."""

    def keep(self, frame: Frame, blobs: BlobTable, things: Things) -> NDArray[np.bool_]:
        """(N,) whether a blob is as large as an object, compared to the usual one of its color.

        :param things: of the last frame: blobs in which these are merged have not the area of one.
        """
        if not self._sought:
            return np.ones(len(blobs.area), bool)
        (height, width), stamp = size_of(frame), frame.stamp
        half = USUAL_SECONDS / 2 * NANOSECONDS
        elapsed = stamp - self._measured
        if not 0 <= elapsed < half:
            last = self._usual[0] * (half <= elapsed < 2 * half)
            self._usual = np.stack([np.zeros_like(last), last])
            self._measured = stamp
        color = blobs.label.astype(np.intp) - 1
        known = self._usual.max(axis=0)[color]
        most = np.maximum(MOST_SUDDEN * known, LARGEST_SHARE * height * width)
        fills = (known > 0) & (blobs.area > most)
        self._unfilled[np.bincount(color[fills], minlength=len(self._unfilled)) == 0] = stamp
        sudden = fills & (stamp - self._unfilled[color] < USUAL_SECONDS * NANOSECONDS)
        merged = hold_several(things.mean, things.label, things.area, blobs)
        for k in self._sought:
            this = (color == k) & ~sudden
            area = blobs.area[this & ~merged if self._usual[:, k].any() else this]
            self._usual[0, k] = max(self._usual[0, k], _usual_area(area))
        usual = self._usual.max(axis=0)[color]
        mine = np.isin(color, self._sought)
        kept = ~mine | ((blobs.area >= LEAST_SHARE * usual) & ~sudden)
        kept[kept & mine] = ~_is_piece(blobs.take(kept & mine), usual[kept & mine])
        return kept


def _usual_area(area: NDArray[np.int64]) -> float:
    """The area of one object: in a crowd, the largest blob consists of many that touch."""
    if not len(area):
        return 0.0
    area = np.sort(area)
    behind = np.cumsum(area)
    return float(area[np.searchsorted(behind, CROWD_SHARE * behind[-1])])


def _is_piece(blobs: BlobTable, usual: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,) whether a blob is beside a much larger one, or enclosed by a larger one of its color.

    The larger one may have another color, of which the shade on its underside is the color sought.

    :param usual: (N,) usual areas: what is beside many that touch is compared to one of them.
    """
    low = blobs.box[:, None, :2] - PIECE_REACH * blobs.box[:, None, 2:]
    high = blobs.box[:, None, :2] + (1 + PIECE_REACH) * blobs.box[:, None, 2:]
    beside = ((blobs.mean >= low) & (blobs.mean <= high)).all(axis=2)
    whole = np.minimum(blobs.area[:, None], usual)
    pieces = np.asarray((beside & (blobs.area < PIECE_SHARE * whole)).any(axis=0))
    pieces &= ~_is_disc(blobs)
    beside &= blobs.label == blobs.label[:, None]
    low, high = blobs.box[:, :2], blobs.box[:, :2] + blobs.box[:, 2:]
    within = (low[:, None] < low).all(axis=2) & (high[:, None] > high).all(axis=2)
    candidates = np.argwhere(beside & within & ~pieces).tolist()
    ends = blobs.runs.ends() if candidates else ()
    for outer, inner in candidates:
        pieces[inner] |= _surrounds(blobs, ends, outer, inner)
    return pieces


def _is_disc(blobs: BlobTable) -> NDArray[np.bool_]:
    """(N,) whether a blob is a whole disc: an ellipse that is filled, and nearly round."""
    minor, major = blobs.axes
    filled = blobs.area >= DISC_FILLED * 4 * np.pi * np.sqrt(minor * major)
    return np.asarray(filled & (aspect(blobs) >= DISC_ASPECT) & (blobs.area >= DISC_PIXELS))


def _surrounds(
    blobs: BlobTable, ends: tuple[NDArray[np.intp], ...], outer: int, inner: int
) -> bool:
    """Whether a blob has pixels on all sides of another's center, such as the frame of a print."""
    u, v = np.rint(blobs.mean[inner])
    first = blobs.first_run[outer]
    mine = slice(first, first + blobs.run_count[outer])
    row, left, right = (column[mine] for column in ends)
    here, along = row == v, (left <= u) & (u < right)
    sides = here & (right <= u), here & (left > u), along & (row < v), along & (row > v)
    return all(side.any() for side in sides)
