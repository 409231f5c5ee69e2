"""Follows the shades of a color's objects from picture to picture (see shades.py)."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.cells import lab_of_cells
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.growth import SIZE_STEP
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.light_change import lab_in_light
from colortrack_ros.detection.light_change import lightest_channel
from colortrack_ros.detection.shades import reach_of
from colortrack_ros.detection.shades import shades_beyond
from colortrack_ros.detection.shades import with_shades

SHADES_SECONDS = 1.0
"""Interval between two searches for further shades of a color [s], once its unrestricted period is
over. A search takes 20 to 60 ms, and the light on an object changes no faster than the pool."""

MOST_LARGER = 1.25
"""Growth of the half axes from which on shades are searched for again, beyond the larger extent."""


LEAST_LEFT, MOST_AROUND = 1 / 2, 2.0
"""Share of their pixels that fewer shades must keep, and growth of the pixels of all shades from
which on this does not matter. A shadow that touches an object ends the search for its shades in the
shadow, but takes nothing from the object; half of the wall is no part of it. Assumed."""

LESS_REACH = float(np.exp(SIZE_STEP))
"""Factor by which the reach is taken back, step by step: that of the sizes tried."""

LONG_AGO = -(1 << 62)
"""Stamp of a search that is to be repeated [ns]."""

ENOUGH_SEARCHES = 3
"""Searches that must have found as many shades before they are kept like this. Assumed: the first
ones, of an object that is still coming into the picture, find others."""


class _Search(NamedTuple):
    """When further shades of a color were searched for, beyond which extent, and what was found."""

    stamp: int
    whole: Extent
    shades: tuple[Triple, ...]

    def is_outdated(self, stamp: int, pause: float, whole: Extent) -> bool:
        """Whether it is longer ago than a pause [s], or the extent has grown."""
        larger = np.array(whole.axes) > MOST_LARGER * np.array(self.whole.axes)
        return not 0 <= stamp - self.stamp < pause * NANOSECONDS or bool(larger.any())


class ShadeFollower:
    """Extends one color to the shades of its objects, a bit more with each update."""

    def __init__(self) -> None:
        self._reach: float | None = None
        self._last: _Search | None = None
        self._confirmed, self._pixels = 0, 0.0
        self._tried: Triple = (0.0, 0.0, 0.0)
        self.shades: tuple[Triple, ...] | None = None

    def restart(self) -> None:
        """Search for the shades anew."""
        self._last = self.shades = None
        self._confirmed = 0

    def relight(self, gains: NDArray[np.float64]) -> None:
        """Move the shades into another light, and search for them again soon.

        :param gains: (3,) of linear red, green, and blue.
        """
        if self._last is None or self.shades is None:
            return
        self.shades = _lit(self.shades, gains)
        self._last = self._last._replace(stamp=LONG_AGO, shades=_lit(self._last.shades, gains))

    def whole(self, extent: Extent) -> Extent:
        """The extent of the color with its near shades.

        It is no larger than when further shades were found: their ellipsoids have the same size,
        and larger ones may include what is not the object's.
        """
        whole = self._near(extent)
        if not self.shades:
            return whole
        dL, da, db = np.minimum(whole.axes, self._tried).tolist()
        return replace(whole, axes=(dL, da, db))

    def _near(self, extent: Extent) -> Extent:
        return with_shades(extent, 1.0 if self._reach is None else self._reach)

    def follow(
        self,
        cells: NDArray[np.uint16],
        counts: NDArray[np.float64],
        extent: Extent,
        apart: list[Triple],
        share: float,
        stamp: int,
        pause: float = SHADES_SECONDS,
    ) -> bool:
        """Take a picture into account.

        A sudden extension would include pixels that were next to the object by chance in one
        picture, so more shades, or fewer, count when two searches in a row find them. These run
        less often, since they take longer than the rest of an update.

        :param cells, counts: (H, W) and (65536,) of :func:`sample_colors`.
        :param apart: colors that other objects have, which are left outside.
        :param share: weight of this picture.
        :param pause: least time between two searches [s].
        :returns: whether an object of the color itself is in the picture.
        """
        reach = reach_of(cells, counts, extent, apart)
        if reach is None:
            return False
        known = reach if self._reach is None else self._reach
        self._reach = min(reach, float(known + share * (reach - known)))
        whole, last = self._near(extent), self._last
        if last is None or last.is_outdated(stamp, pause, whole):
            new = shades_beyond(cells, counts, whole, apart)
            recent = new if self.shades is None else self.shades, last.shades if last else new, new
            self._change(sorted(recent, key=len)[1], counts, whole)
            if len(new) >= len(self.shades or ()):
                self._confirmed, self._pixels = self._confirmed + 1, _pixels(counts, whole, new)
                self._tried = whole.axes
            self._last = _Search(stamp, whole, new)
        return True

    def leave(self, counts: NDArray[np.float64], extent: Extent, most: float) -> bool:
        """Take a picture into account where the color itself is not, or hardly.

        Shades that still have many pixels there are those of something else: they are given up.

        :param counts: (65536,) of :func:`sample_colors`.
        :param most: largest number of pixels that the object may have.
        :returns: whether any are given up.
        """
        before = self._reach, self.shades
        if self.shades and _pixels(counts, self.whole(extent), self.shades) > most:
            self.shades = ()
        (filled,) = counts.nonzero()
        away = nearest_sample(lab_of_cells(filled), (extent.lab,), np.array(extent.axes))
        while self._reach and self._reach > 1 and counts[filled[away < self._reach]].sum() > most:
            self._reach = max(1.0, self._reach / LESS_REACH)
        return before != (self._reach, self.shades)

    def _change(
        self, shades: tuple[Triple, ...], counts: NDArray[np.float64], whole: Extent
    ) -> None:
        """Replace the shades, unless that loses most of an object that is there as before."""
        if self.shades and len(shades) < len(self.shades) and self._confirmed >= ENOUGH_SEARCHES:
            left, there = (_pixels(counts, whole, each) for each in (shades, self.shades))
            if left < LEAST_LEFT * there and there < MOST_AROUND * self._pixels:
                return
        self.shades = shades


def _lit(shades: tuple[Triple, ...], gains: NDArray[np.float64]) -> tuple[Triple, ...]:
    """Shades in another light, but for those that no camera shows."""
    moved = [lab_in_light(shade, gains) for shade in shades]
    return tuple(shade for shade in moved if lightest_channel(shade) <= 1)


def _pixels(counts: NDArray[np.float64], whole: Extent, shades: tuple[Triple, ...]) -> float:
    """Number of pixels of a color and its shades in a picture."""
    (filled,) = counts.nonzero()
    color = lab_of_cells(filled)
    inside = nearest_sample(color, (whole.lab, *shades), np.array(whole.axes)) < 1
    return float(counts[filled] @ inside)
