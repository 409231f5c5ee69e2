"""Tolerance estimation: finds how far a color extends in the pictures, and follows the light."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.dither import of_palette
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.extent import find_extent
from colortrack_ros.detection.extent import LARGEST_GROUND
from colortrack_ros.detection.extent import LARGEST_SHARE
from colortrack_ros.detection.extent import measure
from colortrack_ros.detection.extent import nearest_color
from colortrack_ros.detection.extent import pixels_near
from colortrack_ros.detection.extent import sample_colors
from colortrack_ros.detection.extent import SHAPE
from colortrack_ros.detection.growth import FEWEST_PIXELS
from colortrack_ros.detection.growth import MOST_GROWTH
from colortrack_ros.detection.growth import NEAR
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.light_change import as_shown
from colortrack_ros.detection.light_change import in_light
from colortrack_ros.detection.light_change import LightChange
from colortrack_ros.detection.reference import apart_from
from colortrack_ros.detection.reference import MAX_TOLERANCE
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.reference import Triple
from colortrack_ros.detection.shade_follower import ShadeFollower
from colortrack_ros.detection.shade_follower import SHADES_SECONDS
from colortrack_ros.detection.usual_areas import UsualAreas
from colortrack_ros.encodings import plain

# Unless noted otherwise, the constants below were chosen. On four real clips, `python
# benchmark/colors.py --constants` halves and doubles them: the recall of each clip changes by at
# most 1 or 2 points.

LOOK_SECONDS = 0.25
"""Interval between two updates of the colors [s]; an update takes about 2 ms. Assumed: 1 % of the
time."""

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

MANY_SPECKS = 20
"""Number of blobs in one picture, each too small for an object, above which the user is warned.
Noise on outlines causes a few. Assumed."""

ABSENT_SECONDS = 2.0
"""Time that a color must be missing from the start before the user is warned [s]. Assumed: time
to put the object in front of the camera."""

NOWHERE, NOTHING = (0.0, -128.0, -128.0), 1e-6
"""Color and tolerance that stand in for a color missing from the picture: outside sRGB."""


class ColorFinder:
    """Estimates the tolerance of each color that has none, and the least area of its blobs.

    :param colors: as configured; tolerance 0 means to estimate it.
    """

    def __init__(self, colors: tuple[ReferenceColor, ...]) -> None:
        self._given = self._colors = colors
        self._sought = [k for k, color in enumerate(colors) if color.is_sought]
        self._found: dict[int, Extent] = {}
        self._lit: dict[int, Extent] = {}  # as the light has changed since, however light
        self._since: dict[int, int] = {}
        self._shades = {k: ShadeFollower() for k in self._sought}
        self._pool = np.zeros(0)
        self._looked = 0
        self._first: int | None = None
        self._fills: set[int] = set()
        self._nearest: dict[int, tuple[int, int, int]] = {}
        self._specks = 0
        self._seen: set[int] = set()
        self._light = LightChange()
        self._usual = UsualAreas(len(colors), self._sought)

    def read_palette(self, frame: Frame) -> None:
        """Take the colors that are not found yet for what a dithered picture shows by them.

        Whoever read one off a pixel got a color of the palette, which no thing may have.
        """
        if missing := self._missing:
            colors = list(self._colors)
            shown = of_palette([self._given[k] for k in missing], frame)
            for k, color in zip(missing, shown, strict=True):
                colors[k] = color
            self._colors = tuple(colors)

    @property
    def least_chroma(self) -> float:
        """Distance of the dullest sought color from gray [CIELAB units]; 0 if none is sought."""
        return min((float(np.hypot(*self._colors[k].lab[1:])) for k in self._sought), default=0.0)

    def look(self, frame: Frame) -> bool:
        """Update the colors from a picture, if an update is due.

        :returns: whether any color has changed.
        """
        stamp = frame.stamp
        elapsed = (stamp - self._looked) / NANOSECONDS
        due = not (self._pool.size and 0 <= elapsed < LOOK_SECONDS)
        missing = self._missing
        if not self._sought or not (due or missing):
            return False
        frame = plain(frame)
        cells, now = sample_colors(frame.image, frame.encoding)
        before = self._state()
        present, share = list[int](), 0.0
        if due:
            share = self._pool_colors(now, elapsed, self._light.change(frame))
            self._looked = stamp
            self._first = stamp if self._first is None else self._first
            present = [k for k in self._found if self._renew(k, now, stamp)]
        for k in missing:
            if (extent := self._find(k, now, self._colors[k].lab)) is not None:
                self._found[k] = self._lit[k] = extent
                self._since[k] = stamp
                present.append(k)
            elif pixels_near(now, self._colors[k].lab) >= FEWEST_PIXELS:
                self._fills.add(k)
        has_left = False
        for k, extent in self._found.items():
            if self._colors[k].is_sampled or self._colors[k].inverted:
                continue
            is_seen = False
            if k in present:
                apart = apart_from(self._colors, k)
                pause = LOOK_SECONDS if self._is_new(k, stamp) else SHADES_SECONDS
                is_seen = self._shades[k].follow(cells, now, extent, apart, share, stamp, pause)
            if due and not is_seen:
                has_left |= self._shades[k].leave(now, extent, extent.pixels / FEWEST_LEFT)
        return has_left or before != self._state()

    @property
    def _missing(self) -> list[int]:
        """The sought colors that have not been found yet."""
        return [k for k in self._sought if k not in self._found]

    def _state(self) -> list[object]:
        return [(self._found.get(k), self._shades[k].shades) for k in self._sought]

    def _is_new(self, k: int, stamp: int) -> bool:
        return 0 <= stamp - self._since[k] <= POOL_SECONDS * NANOSECONDS

    def _pool_colors(
        self, now: NDArray[np.float64], elapsed: float, light: NDArray[np.float64]
    ) -> float:
        """Add a picture's colors to the pool, and follow the light.

        :param elapsed: since the last update [s]; light: (3,) factors by which it has scaled red,
            green, and blue.
        :returns: the weight of the picture.
        """
        is_other = bool((light != 1).any())
        if elapsed < 0 or is_other or not self._pool.size:
            self._pool = now.copy()
        if is_other:
            self._lit = {k: in_light(extent, light) for k, extent in self._lit.items()}
            self._found = {k: as_shown(extent) for k, extent in self._lit.items()}
        for shades in self._shades.values():
            if elapsed < 0:
                shades.restart()
            elif is_other:
                shades.relight(light)
        share = float(-np.expm1(-max(elapsed, 0) / POOL_SECONDS))
        self._pool += (now - self._pool) * share
        return share

    def _find(
        self, k: int, counts: NDArray[np.float64], lab: Triple, allowed: float = 0.0
    ) -> Extent | None:
        color = self._colors[k]
        known, apart = (lab, color.samples, color.others), apart_from(self._colors, k)
        found = find_extent(counts, *known, _most_of(color), allowed=allowed, apart=apart)
        if found is None or not color.inverted:
            return found
        # The rest shrinks as the background color grows: a lot if the background is unevenly lit.
        rest = counts.sum() - found.pixels
        return found if found.growth * found.pixels < MOST_GROWTH * rest else None

    def _renew(self, k: int, now: NDArray[np.float64], stamp: int) -> bool:
        """Replace a color's extent with its current one, unless that belongs to another object.

        :returns: whether enough of the color is in the picture.
        """
        known, color, pool = self._found[k], self._colors[k], self._pool
        pooled = measure(pool, known)
        pixels = measure(now, known).pixels
        if pixels < LEAST_PRESENT * pooled.pixels:
            return False
        is_new = self._is_new(k, stamp)
        # far more pixels at once may be of what else has come: the pooled color is a mixture then
        labs = (known.lab, pooled.lab)[: 1 + (pixels < known.pixels / FEWEST_LEFT)]

        def is_same(extent: Extent) -> bool:
            way = nearest_sample(np.array([extent.lab]), labs, SHAPE)
            is_near = way < NEAR and extent.growth < MOST_GROWTH
            share = extent.pixels / max(pooled.pixels, 1)
            is_whole = share > LEAST_PRESENT or extent.growth < pooled.growth
            return bool(is_near and is_whole and extent.pixels > FEWEST_LEFT * known.pixels)

        allowed = 0 if is_new else known.pixels / FEWEST_LEFT
        is_followed = not (is_new or color.is_sampled or color.inverted)
        for lab in (labs[-1], color.lab) if is_followed else (color.lab,):
            extent = self._find(k, pool, lab, allowed)
            if extent is not None and (is_new or is_same(extent)):
                self._found[k] = self._lit[k] = extent
                break
        return True

    def resolve(self, colors: tuple[ReferenceColor, ...]) -> tuple[ReferenceColor, ...]:
        """The colors, with estimates for what was not given."""
        found = list(colors)
        for k in self._sought:
            extent = self._found.get(k)
            if extent is None:
                found[k] = replace(
                    colors[k], lab=NOWHERE, tolerance=NOTHING, samples=(), inverted=False
                )
                continue
            extent, shades = self._shades[k].whole(extent), self._shades[k].shades
            dL, da, db = (min(axis, MAX_TOLERANCE) for axis in extent.axes)
            found[k] = replace(
                colors[k],
                lab=extent.lab,
                tolerance=max(da, db),
                tolerance_lab=(dL, da, db),
                samples=colors[k].samples if shades is None else shades,
            )
        return tuple(found)

    @property
    def trouble(self) -> str:
        """Why colors cannot be found, and what to do about it; empty if there is no problem."""
        waited = self._looked - (self._first or 0) > ABSENT_SECONDS * NANOSECONDS
        for k in self._missing:
            name = self._colors[k].name
            if k in self._fills:
                return (
                    f'{name} fills more than {_most_of(self._colors[k]):.0%} of the picture: set '
                    f'{name}.tolerance, or {name}.others to colors that are not it'
                )
            if waited:
                if k not in self._nearest:  # once: trouble is read for every picture
                    self._nearest[k] = nearest_color(self._pool, self._colors[k].lab)
                return (
                    f'{name} is not in the picture, where {",".join(map(str, self._nearest[k]))} '
                    'is nearest (r,g,b): pick its color there, with pick_color'
                )
        for k, extent in self._found.items():
            if extent.growth > MOST_GROWTH:
                name = self._colors[k].name
                return f'{name} runs into other colors: pick another side, or set {name}.others'
        if self._specks > MANY_SPECKS:
            return (
                f'{self._specks} specks of the colors in one picture, which are dropped: set '
                'NAME.others to colors that are not it, or moving_only if the things alone move'
            )
        return ''

    @property
    def unseen(self) -> str:
        """Which color is there, but never as a blob, and what to do; empty if there is none."""
        for k in self._found.keys() - self._seen:
            if self._looked - self._since[k] > ABSENT_SECONDS * NANOSECONDS:
                told = 'pick another pixel of it, or set erosion_size to 1 and a smaller min_area'
                return f'{self._colors[k].name} is there, but in pieces that are too small: {told}'
        return ''

    def keep(self, blobs: BlobTable, pixels: int, stamp: int) -> NDArray[np.bool_]:
        """(N,) whether a blob may be an object of its color; pixels: of the picture."""
        kept = self._usual.keep(blobs, pixels, stamp)
        if len(self._seen) < len(self._colors):
            self._seen.update((blobs.label - 1).tolist())
        self._specks = int(np.count_nonzero(~kept))
        return kept


def _most_of(color: ReferenceColor) -> float:
    """Largest share of the picture that a color may cover."""
    return LARGEST_GROUND if color.inverted else LARGEST_SHARE
