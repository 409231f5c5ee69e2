"""One sought color: how far it extends in the pictures, from look to look."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.extent import find_extent
from colortrack_ros.detection.extent import LARGEST_GROUND
from colortrack_ros.detection.extent import LARGEST_SHARE
from colortrack_ros.detection.extent import measure
from colortrack_ros.detection.extent import pixels_near
from colortrack_ros.detection.extent import SHAPE
from colortrack_ros.detection.growth import FEWEST_PIXELS
from colortrack_ros.detection.growth import MOST_GROWTH
from colortrack_ros.detection.growth import NEAR
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.light_change import as_shown
from colortrack_ros.detection.light_change import in_light
from colortrack_ros.detection.light_change import lab_in_light
from colortrack_ros.detection.reference import MAX_TOLERANCE
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.shade_follower import ShadeFollower
from colortrack_ros.detection.shade_follower import SHADES_SECONDS
from colortrack_ros.detection.small_color import small_extent
from colortrack_ros.detection.strangers import Strangers

# Unless noted otherwise, the constants below were chosen. On four real clips, `python
# benchmark/colors.py --constants` halves and doubles them: the recall of each clip changes by at
# most 1 or 2 points.

LOOK_SECONDS = 0.25
"""Interval between two updates of the colors [s]; an update takes 9 ms, of which 4 look for
strangers (640x480). Assumed: 4 % of the time."""

POOL_SECONDS = 1.0
"""Time constant of the pooled color counts [s]. For this long, a color that has just appeared may
change without restriction. It is also the time constant for following the light."""

FEWEST_LEFT = 1 / 4
"""Share of its pixels that a color must keep to follow the light; the inverse limits its growth.
When an object has left, slightly similar pixels must not pull the color away. Assumed: light
changes slower than by a factor of four within POOL_SECONDS."""

LEAST_PRESENT = 1 / 2
"""Share of its pooled pixels that a color must have in a picture to be updated, and that it keeps
unless a deeper gap is found. Otherwise an object that leaves, or a hand that covers it, changes its
color to that of what is left. Assumed: half of an object still is that object."""

CLEAR_GROWTH = 0.7 * MOST_GROWTH
"""Growth up to which an extent ends in a gap. Beyond, colors shade off into others, as what is
smeared does, whose mean runs away: of scene `fast` 99 % are found, with 1 35 %."""

NOWHERE, NOTHING = (0.0, -128.0, -128.0), 1e-6
"""Color and tolerance that stand in for a color missing from the picture: outside sRGB."""


class SoughtColor:
    """Estimates the tolerance of one color.

    :param color: as configured.

    apart: the other colors, which other objects have.
    taken: the other colors as far as they extend, if any is given by its name.
    found: its extent; None until it is in the picture.
    since: when it was found, or found anew [ns].
    small: the extent of the few pixels of it while it is not found; None if there are none.
    """

    def __init__(self, color: ReferenceColor) -> None:
        self.color, self.apart = color, list[Triple]()
        self.taken: tuple[ReferenceColor, ...] = ()
        self.found: Extent | None = None
        self.small: Extent | None = None
        self.since = 0
        self._lit: Extent | None = None  # as the light has changed since, however light
        self._lab = color.lab  # so is this
        self._strangers = Strangers()
        self._shades = ShadeFollower()

    @property
    def state(self) -> Any:
        """What the color table depends on."""
        return self.found, self.small, self._shades.shades

    @property
    def largest_share(self) -> float:
        """Largest share of the picture that the color may cover."""
        return LARGEST_GROUND if self.color.inverted else LARGEST_SHARE

    def read(self, cells: NDArray[np.uint16], counts: NDArray[np.float64], is_due: bool) -> float:
        """How far what a picture shows of it is from what is meant, which is given here: 0.

        :param cells, counts: (H, W) and (65536,) of :func:`sample_colors`.
        :param is_due: whether an update is due.
        """
        return 0.0

    def seek(self, counts: NDArray[np.float64], stamp: int) -> bool:
        """Look for the color where it has not been found yet; return whether it is there.

        :param counts: (65536,) of :func:`sample_colors`.
        """
        return self._start(self._find(counts, self.color.lab), stamp)

    def is_in(self, counts: NDArray[np.float64]) -> bool:
        """Whether a picture that was read shows it, however much of it there is."""
        return pixels_near(counts, self.color.lab) >= FEWEST_PIXELS

    def is_crossed(self) -> bool:
        """Whether others have come between this color and what read() has chosen: never."""
        return False

    def outshone(self, cells: NDArray[np.uint16], now: NDArray[np.float64], stamp: int) -> float:
        """How far what is likelier to be meant is from that: infinite, as this is what is given.

        :param cells, now: (H, W) and (65536,) of :func:`sample_colors`.
        """
        return np.inf

    def goes_over(self, stamp: int) -> bool:
        """Take the color that has outshone it, if any; return whether one has."""
        return False

    def restart(self) -> None:
        """Search for the shades anew."""
        self._shades.restart()

    def relight(self, light: NDArray[np.float64], now: NDArray[np.float64]) -> None:
        """Follow a change of the light, unless the color is there as before.

        :param light: (3,) factors of linear red, green, and blue; now: (65536,) counts of the
            picture.
        """
        if self._lit is None or self.found is None:
            return
        lit = in_light(self._lit, light)
        shown = as_shown(lit)
        if _is_as_before(now, self.found, shown):
            return
        self._lit, self.found = lit, shown
        if not self.color.is_sampled:
            self._lab = lab_in_light(self._lab, light)
        self._shades.relight(light)
        self._strangers.relight(light)

    def renew(self, now: NDArray[np.float64], pool: NDArray[np.float64], stamp: int) -> bool:
        """Replace the extent with the current one, unless that belongs to another object.

        :param now, pool: (65536,) counts of a picture, and of the last second.
        :returns: whether enough of the color is in the picture.
        """
        known, color = self.found, self.color
        assert known is not None
        pooled = measure(pool, known)
        pixels = measure(now, known).pixels
        if pixels < LEAST_PRESENT * pooled.pixels:
            return False
        is_new = self._is_new(stamp)
        # far more pixels at once may be of what else has come: the pooled color is a mixture then
        labs = (known.lab, pooled.lab)[: 1 + (pixels < known.pixels / FEWEST_LEFT)]
        clear = min(max(known.growth, CLEAR_GROWTH), MOST_GROWTH)

        def is_same(extent: Extent) -> bool:
            way = nearest_sample(np.array([extent.lab]), labs, SHAPE)
            is_near = way < NEAR and extent.growth < clear
            share = extent.pixels / max(pooled.pixels, 1)
            is_whole = share > LEAST_PRESENT or extent.growth < pooled.growth
            return bool(is_near and is_whole and extent.pixels > FEWEST_LEFT * known.pixels)

        allowed = 0 if is_new else known.pixels / FEWEST_LEFT
        is_followed = not (is_new or color.is_sampled or color.inverted)
        for lab in (labs[-1], color.lab) if is_followed else (self._lab,):
            extent = self._find(pool, lab, allowed, self._strangers.apart)
            if extent is not None and (is_new or is_same(extent)):
                if extent.pixels < LEAST_PRESENT * known.pixels:
                    self._start_anew(stamp)  # since another color has come, its shades are beyond
                self._take(extent)
                break
        return True

    def extend(
        self,
        cells: NDArray[np.uint16],
        now: NDArray[np.float64],
        share: float,
        stamp: int,
        is_present: bool,
        is_due: bool,
    ) -> bool:
        """Follow the shades of its objects, and leave out strangers.

        :param cells, now: (H, W) and (65536,) of :func:`sample_colors`; share: weight of the
            picture.
        :returns: whether any shades are given up.
        """
        extent, is_seen = self.found, False
        if extent is None or self.color.is_sampled or self.color.inverted:
            return False
        if is_present:
            extent = self._part(cells, now, stamp, extent)
            pause = LOOK_SECONDS if self._is_new(stamp) else SHADES_SECONDS
            apart = [*self.apart, *self._strangers.apart]
            is_seen = self._shades.follow(cells, now, extent, apart, share, stamp, pause)
        if not is_due or is_seen:
            return False
        return self._shades.leave(now, extent, extent.pixels / FEWEST_LEFT)

    def seek_small(self, pool: NDArray[np.float64]) -> None:
        """Look for the few pixels of small things while it is not found; pool: as of renew()."""
        if self.found is None and not (self.color.is_sampled or self.color.inverted):
            self.small = small_extent(pool, self.color, self.apart, self.small)

    def resolve(self, is_small: bool = False) -> ReferenceColor:
        """The color, with estimates for what was not given.

        :param is_small: whether to extend it to the few pixels of small things while it is missing.
        """
        if self.found is None:
            if is_small and self.small:
                lab, axes = self.small.lab, self.small.axes
                return replace(self.color, lab=lab, tolerance=axes[1], tolerance_lab=axes)
            return replace(self.color, lab=NOWHERE, tolerance=NOTHING, samples=(), inverted=False)
        extent, shades = self._shades.whole(self.found), self._shades.shades
        dL, da, db = (min(axis, MAX_TOLERANCE) for axis in extent.axes)
        return replace(
            self.color,
            lab=extent.lab,
            tolerance=max(da, db),
            tolerance_lab=(dL, da, db),
            samples=self.color.samples if shades is None else shades,
        )

    def _start(self, extent: Extent | None, stamp: int) -> bool:
        """Take the extent that was found, if any, as its first."""
        if extent is None:
            return False
        self._take(extent)
        self._lab, self.since = self.color.lab, stamp
        return True

    def _part(
        self, cells: NDArray[np.uint16], now: NDArray[np.float64], stamp: int, extent: Extent
    ) -> Extent:
        """Find the extent anew if it includes strangers: from then on, the color is new again."""
        whole, lab = self._shades.whole(extent), self._lab
        own = self._strangers.part(
            cells, now, lab, whole, lambda: self._find(now, lab, 0.0, self._strangers.apart)
        )
        if own is whole:
            return extent
        self._take(own)
        self._start_anew(stamp)
        return own

    def _start_anew(self, stamp: int) -> None:
        """Search for the shades soon, and let the color change without restriction."""
        self._shades.restart()
        self.since = stamp

    def _is_new(self, stamp: int) -> bool:
        return 0 <= stamp - self.since <= POOL_SECONDS * NANOSECONDS

    def _take(self, extent: Extent) -> None:
        self.found = self._lit = extent
        self.small = None

    def _find(
        self,
        counts: NDArray[np.float64],
        lab: Triple,
        allowed: float = 0.0,
        strangers: Sequence[Triple] = (),
    ) -> Extent | None:
        color, apart = self.color, [*self.apart, *strangers]
        known = lab, color.samples, color.others
        found = find_extent(counts, *known, self.largest_share, allowed=allowed, apart=apart)
        if found is None or not color.inverted:
            return found
        # The rest shrinks as the background color grows: a lot if the background is unevenly lit.
        rest = counts.sum() - found.pixels
        return found if found.growth * found.pixels < MOST_GROWTH * rest else None


def _is_as_before(counts: NDArray[np.float64], known: Extent, lit: Extent) -> bool:
    """Whether a color is in a picture as it was, and hardly as in other light.

    Of two changes of the light, to and fro, one may not have been told. What is as the color was
    may also be something else, as the wall in colder light; then the color is there as lit.

    :param counts: (65536,) of :func:`sample_colors`; known, lit: the color before and after.
    """
    pixels, pixels_lit = (measure(counts, extent).pixels for extent in (known, lit))
    return pixels > LEAST_PRESENT * known.pixels and pixels_lit < FEWEST_LEFT * known.pixels
