"""Follows the shades of a color's objects from picture to picture (see shades.py)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.reference import Triple
from colortrack_ros.detection.shades import reach_of
from colortrack_ros.detection.shades import shades_beyond
from colortrack_ros.detection.shades import with_shades

SHADES_SECONDS = 1.0
"""Interval between two searches for further shades of a color [s], once its unrestricted period is
over. A search takes 20 to 60 ms, and the light on an object changes no faster than the pool."""

MOST_LARGER = 1.25
"""Growth of the half axes from which on shades are searched for again: their ellipsoids grow as
much, and may include what is not the object's."""


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
        self.shades: tuple[Triple, ...] | None = None

    def restart(self) -> None:
        """Search for the shades anew: the light is another one."""
        self._last = self.shades = None

    def whole(self, extent: Extent) -> Extent:
        """The extent of the color with its near shades."""
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
    ) -> None:
        """Take a picture into account.

        A sudden extension would include pixels that were next to the object by chance in one
        picture, so more shades, or fewer, count when two searches in a row find them. These run
        less often, since they take longer than the rest of an update.

        :param cells, counts: (H, W) and (65536,) of :func:`sample_colors`.
        :param apart: colors that other objects have, which are left outside.
        :param share: weight of this picture.
        :param pause: least time between two searches [s].
        """
        reach = reach_of(cells, counts, extent, apart)
        if reach is None:
            return
        known = reach if self._reach is None else self._reach
        self._reach = min(reach, float(known + share * (reach - known)))
        whole, last = self.whole(extent), self._last
        if last is None or last.is_outdated(stamp, pause, whole):
            new = shades_beyond(cells, counts, whole, apart)
            recent = new if self.shades is None else self.shades, last.shades if last else new, new
            self.shades = sorted(recent, key=len)[1]
            self._last = _Search(stamp, whole, new)
