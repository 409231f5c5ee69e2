"""Tolerance estimation: finds how far a color extends in the pictures, and follows the light."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.dither import of_palette
from colortrack_ros.detection.extent import sample_colors
from colortrack_ros.detection.growth import MOST_GROWTH
from colortrack_ros.detection.light_change import LightChange
from colortrack_ros.detection.missing import why_missing
from colortrack_ros.detection.named_color import NamedColor
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.sought_color import LOOK_SECONDS
from colortrack_ros.detection.sought_color import POOL_SECONDS
from colortrack_ros.detection.sought_color import SoughtColor
from colortrack_ros.detection.touching import Things
from colortrack_ros.detection.usual_areas import UsualAreas
from colortrack_ros.encodings import plain

# Unless noted otherwise, the constants below were chosen. On four real clips, `python
# benchmark/colors.py --constants` halves and doubles them: the recall of each clip changes by at
# most 1 or 2 points.

MANY_SPECKS = 20
"""Number of blobs in one picture, each too small for an object, above which the user is warned.
Noise on outlines causes a few. Assumed."""

ABSENT_SECONDS = 2.0
"""Time that a color must be missing from the start before the user is warned [s]. Assumed: time
to put the object in front of the camera."""


class ColorFinder:
    """Estimates the tolerance of each color that has none, and the least area of its blobs.

    :param colors: as configured; tolerance 0 means to estimate it.
    """

    def __init__(self, colors: tuple[ReferenceColor, ...]) -> None:
        self._given = colors
        self._sought = {
            k: NamedColor(color) if color.preset else SoughtColor(color)
            for k, color in enumerate(colors)
            if color.is_sought
        }
        self._keep_apart()
        self._pool = np.zeros(0)
        self._share, self._looked, self._last = 0.0, 0, 0
        self._waiting, self._is_update = list[int](), False
        self._first: int | None = None
        self._fills: set[int] = set()
        self._absent: dict[int, str] = {}
        self._specks = 0
        self._seen: set[int] = set()
        self._light = LightChange()
        self._usual = UsualAreas(len(colors), list(self._sought))

    def take_over(self, before: 'ColorFinder') -> None:
        """Go on with what another one has learned of the light, and of the colors that both have.

        Their limits of the area may differ.
        """
        known = {_unlimited(color): k for k, color in enumerate(before._given)}
        for k, color in enumerate(self._given):
            old = before._sought.get(known.get(_unlimited(color), -1))
            if old is not None:
                old.color = replace(old.color, min_area=color.min_area, max_area=color.max_area)
                self._sought[k] = old
        self._pool, self._looked, self._light = before._pool, before._looked, before._light
        self._keep_apart()

    def read_palette(self, frame: Frame) -> None:
        """Take the colors that are not found yet for what a dithered picture shows by them.

        Whoever read one off a pixel got a color of the palette, which no thing may have.
        """
        if missing := self.missing:
            shown = of_palette([self._given[k] for k in missing], frame)
            for k, color in zip(missing, shown, strict=True):
                self._sought[k].color = color
            self._keep_apart()

    def _keep_apart(self) -> None:
        """Tell each color those of the others, as the pictures show them."""
        unseen = [k for k in self.missing if self._given[k].preset]
        shown = {
            k: self._sought[k].color.lab if k in self._sought else color.lab
            for k, color in enumerate(self._given)
            if k not in unseen  # what a name is typical of may be anything's color
        }
        is_named = any(color.preset for color in self._given)
        extended = self.resolve(self._given, []) if is_named else ()
        for k, sought in self._sought.items():
            sought.apart = [lab for j, lab in shown.items() if j != k]
            sought.taken = (*extended[:k], *extended[k + 1 :])

    @property
    def least_chroma(self) -> float:
        """Distance of the dullest sought color from gray [CIELAB units]; 0 if none is sought."""
        chroma = (float(np.hypot(*each.color.lab[1:])) for each in self._sought.values())
        return min(chroma, default=0.0)

    def look(self, frame: Frame) -> bool:
        """Update the colors whose turn it is from a picture.

        :returns: whether any color has changed.
        """
        stamp = frame.stamp
        since = (stamp - self._last) / NANOSECONDS if self._pool.size else -1.0
        elapsed = (stamp - self._looked) / NANOSECONDS
        self._last = stamp
        due = not (self._pool.size and 0 <= elapsed < LOOK_SECONDS)
        if not self._sought or not (due or self._waiting or self.missing):
            return False
        frame = plain(frame)
        cells, now = sample_colors(frame.image, frame.encoding)
        before = self._state()
        if due:
            self._share = self._pool_colors(now, elapsed, self._light.change(frame))
            self._looked = stamp
            self._first = stamp if self._first is None else self._first
        turn = self._take_turns(due, since)
        present = self._renew(turn, cells, now, stamp) + self._seek(turn, cells, now, stamp)
        for k in self.missing if due else ():
            self._sought[k].seek_small(self._pool)
        has_left, is_due = False, self._is_update
        for k in sorted({*turn, *present}):
            sought, is_there = self._sought[k], k in present
            has_left |= sought.extend(cells, now, self._share, stamp, is_there, is_due)
        if is_other := before != self._state():
            self._keep_apart()  # of a name, another color may be shown
        return has_left or is_other

    def _take_turns(self, due: bool, since: float) -> list[int]:
        """The colors to update or to look for in a picture: all of them within LOOK_SECONDS.

        No picture takes much longer than others, then. In the first one, all colors are looked for.

        :param due: whether an update of all begins; those that still wait come first.
        :param since: time since the picture before [s]; negative if there is none.
        """
        if due:
            self._waiting = list(dict.fromkeys([*self._waiting, *self._sought]))
            self._is_update = True
        elif not self._waiting:
            self._waiting, self._is_update = self.missing, False
        count = max(1, round(len(self._sought) * since / LOOK_SECONDS))
        count = count if since >= 0 else len(self._sought)
        turn, self._waiting = self._waiting[:count], self._waiting[count:]
        return turn

    def _renew(
        self, turn: list[int], cells: NDArray[np.uint16], now: NDArray[np.float64], stamp: int
    ) -> list[int]:
        """Update the colors of a turn that have been found; return which are there.

        A thing to which two names may go over is of the one that fits it best, as in _seek().
        """
        present, has_gone = list[int](), False
        found = [k for k in turn if self._sought[k].found]
        misfit = {k: self._sought[k].outshone(cells, now, stamp) for k in found}
        if np.isfinite(list(misfit.values())).any():
            found = [k for k, sought in self._sought.items() if sought.found]
            misfit |= {
                k: self._sought[k].outshone(cells, now, stamp) for k in found if k not in misfit
            }
        for k in sorted(found, key=misfit.__getitem__):
            sought = self._sought[k]
            if has_gone:
                sought.outshone(cells, now, stamp)
            if sought.goes_over(stamp):
                has_gone = True
                self._keep_apart()
            elif not sought.renew(now, self._pool, stamp):
                continue
            present.append(k)
        return present

    def _seek(
        self, turn: list[int], cells: NDArray[np.uint16], now: NDArray[np.float64], stamp: int
    ) -> list[int]:
        """Look for colors of a turn that have not been found yet; return which are there.

        A thing that has two names, or a name and a color that was picked, is of what fits it best.
        """
        found, is_due = list[int](), self._is_update
        missing = [k for k in turn if self._sought[k].found is None]
        misfit = {k: self._sought[k].read(cells, now, is_due) for k in missing}
        if any(0 < value < np.inf for value in misfit.values()):
            missing = self.missing
            misfit |= {
                k: self._sought[k].read(cells, now, is_due) for k in missing if k not in misfit
            }
        for k in sorted(missing, key=misfit.__getitem__):
            sought = self._sought[k]
            if found and sought.is_crossed():
                sought.read(cells, now, is_due)
            if sought.seek(now, stamp):
                found.append(k)
                self._keep_apart()
            elif sought.is_in(now):
                self._fills.add(k)
        return found

    @property
    def missing(self) -> list[int]:
        """The sought colors that have not been found yet."""
        return [k for k, sought in self._sought.items() if sought.found is None]

    def _state(self) -> list[Any]:
        return [sought.state for sought in self._sought.values()]

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
        for sought in self._sought.values():
            if elapsed < 0:
                sought.restart()
            if is_other:
                sought.relight(light, now)
        share = float(-np.expm1(-max(elapsed, 0) / POOL_SECONDS))
        self._pool += (now - self._pool) * share
        return share

    def resolve(
        self, colors: tuple[ReferenceColor, ...], small: list[int]
    ) -> tuple[ReferenceColor, ...]:
        """The colors, with estimates for what was not given; small: those of small things."""
        sought = self._sought
        return tuple(
            sought[k].resolve(k in small) if k in sought else color
            for k, color in enumerate(colors)
        )

    @property
    def trouble(self) -> str:
        """Why colors cannot be found, and what to do about it; empty if there is no problem."""
        waited = self._looked - (self._first or 0) > ABSENT_SECONDS * NANOSECONDS
        for k in set(self.missing) - self._seen:  # seen ones have small things
            sought = self._sought[k]
            name = sought.color.name
            if k in self._fills:
                return (
                    f'{name} fills more than {sought.largest_share:.0%} of the picture: set '
                    f'{name}.tolerance, or {name}.others to colors that are not it'
                )
            if waited:
                if k not in self._absent:  # once: trouble is read for every picture
                    self._absent[k] = why_missing(sought.color, self._pool)
                return self._absent[k]
        for sought in self._sought.values():
            if sought.found and sought.found.growth > MOST_GROWTH:
                name = sought.color.name
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
        for k, sought in self._sought.items():
            waited = self._looked - sought.since > ABSENT_SECONDS * NANOSECONDS
            if sought.found and k not in self._seen and waited:
                told = 'pick another pixel of it, or set erosion_size to 1 and a smaller min_area'
                return f'{sought.color.name} is there, but in pieces that are too small: {told}'
        return ''

    def keep(self, frame: Frame, blobs: BlobTable, things: Things) -> NDArray[np.bool_]:
        """(N,) whether a blob may be an object of its color; see UsualAreas.keep()."""
        kept = self._usual.keep(frame, blobs, things)
        if len(self._seen) < len(self._given):
            self._seen.update((blobs.label - 1).tolist())
        self._specks = int(np.count_nonzero(~kept))
        return kept


def _unlimited(color: ReferenceColor) -> ReferenceColor:
    """A color without the limits of its area."""
    return replace(color, min_area=0, max_area=0)
