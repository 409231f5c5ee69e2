"""What tells a target from what is beside it, learned from each frame that shows it for sure.

A template asks whether the window is the same; what deforms never is. This asks whether it is
nearer to the target than to all around it: by the answer of a correlation filter, and by colors
(Staple, Bertinetto et al. 2016).
"""

from typing import NamedTuple

import numpy as np

from colortrack_ros.data import Frame
from colortrack_ros.windows.colors import Colors
from colortrack_ros.windows.colors import mean_inside
from colortrack_ros.windows.correlation import CorrelationFilter
from colortrack_ros.windows.correlation import Spectrum
from colortrack_ros.windows.features import CELL
from colortrack_ros.windows.features import describe
from colortrack_ros.windows.features import Floats
from colortrack_ros.windows.features import Pixels
from colortrack_ros.windows.features import sample
from colortrack_ros.windows.peaks import vertex
from colortrack_ros.windows.scale import ScaleFilter

SURROUNDINGS = 1.5
"""Width of what is looked at around the target, as a share of the mean of its width and height: a
square target is searched in a region 2.5 times as wide (Henriques et al. 2015, 7)."""

LEAST_SURROUNDINGS = 24.0
"""The same in pixels, at least: 12 on either side, which is one standard deviation of what a target
that is new goes in a frame (initial_speed, at 25 frames a second)."""

SIDE = 32
"""Cells of that region, in the mean of width and height; 37 in Staple. Fast to transform."""

COLOR_SHARE = 0.3
"""Of colors in the answer (Bertinetto et al. 2016, table 1)."""

NEARNESS = 0.176
"""Share of the answer at the rim that it loses against the expected place, where it loses none
(Bertinetto et al. 2016, "Fully-convolutional Siamese networks", window influence)."""

LEAST_CONTRAST = 0.1
"""Usual contrast of a target whose colors tell it from what is around it: those of ten public
sequences are 0.16 to 0.5."""

NEARBY, LEARNED, RARER = 0.55, 0.7, 0.1
"""Likeness of what is taken for the target near the place where it is expected, and of what it is
learned from. One in 20 and one in 100 of other places are as like, 2 and 30 in 1,000 looks at the
target are less, and e times fewer places for each RARER (``benchmark/likeness.py FOLDER``)."""

FIRST_SHARE = 0.5
"""Of its own peak and contrast in the first frame that the next one has, at least: it had 0.5 to 1
of them on ten public sequences."""

USUAL_FRAMES = 10
"""Frames that the means of peak and contrast go back."""

LEAST_CELLS = 8
"""A region is so many cells wide and high, at least: the width of the filter's peak and as much on
either side."""

CENTERED = 1.0
"""Cells that a target may be beside the middle of what was looked at to be learned from it.
Derived: INNER leaves 1.3 cells of a square target on either side."""

LEAST_DIVISOR = 1e-6
"""Divisors are no smaller."""


class Glimpse(NamedTuple):
    """A part of a frame that was looked at.

    center: (u, v) [px]; patch: its pixels; spectrum: see CorrelationFilter.transform.
    """

    center: Floats
    patch: Pixels
    spectrum: Spectrum


class Sighting(NamedTuple):
    """Where the target seems to be.

    z: (u, v) [px]; R: (2, 2) its covariance [px^2]; peak: height of the answer there; contrast: how
    much likelier the colors there are the target's than those of all that was looked at, -1 to 1;
    glimpse: what was looked at.
    """

    z: Floats
    R: Floats
    peak: float
    contrast: float
    glimpse: Glimpse


class Appearance:
    """What one target looks like.

    :param center: u, v [px].
    :param size: its width and height [px].
    """

    def __init__(self, frame: Frame, center: Floats, size: Floats) -> None:
        region = size + max(SURROUNDINGS * size.mean(), LEAST_SURROUNDINGS)
        self._pitch = float(np.sqrt(region.prod())) / SIDE
        cells = np.maximum(np.rint(region / self._pitch).astype(int), LEAST_CELLS)
        self._cells = np.minimum(cells, 2 * SIDE) | 1  # one is in the middle
        self._size, self._target = size, size / self._pitch
        self._scale = ScaleFilter(frame, center, size)
        patch = self._patch(frame, center)
        self._filter = CorrelationFilter(describe(patch, frame.encoding), self._target)
        self._colors = Colors(patch, self._target * CELL)
        self._sightings = 0
        first = self.look(frame, center)
        self._usual = FIRST_SHARE * np.array([first.peak, first.contrast])

    @property
    def size(self) -> Floats:
        """Width and height [px] now."""
        return np.asarray(self._size * self._scale.scale)

    @property
    def reach(self) -> Floats:
        """How far around a center look() sees a target, by u and v [px]."""
        return np.asarray(self._cells * self._cell / 2 - self.size / 4)

    def look(self, frame: Frame, center: Floats) -> Sighting:
        """Look for the target around a center (u, v) [px]."""
        glimpse = self._glimpse(frame, center)
        answer = self._filter.respond(glimpse.spectrum)
        likely = self._colors.likelihood(glimpse.patch)
        colors = mean_inside(likely, answer.shape[::-1], self._target)
        both = (1 - COLOR_SHARE) * answer + COLOR_SHARE * colors
        both *= 1 - NEARNESS * (1 - self._filter.window)
        v, u = np.unravel_index(int(both.argmax()), both.shape)
        cell = np.array([vertex(both[v], int(u)), vertex(both[:, u], int(v))])
        z = center + (cell - self._cells // 2) * self._cell
        peak, contrast = float(answer[v, u]), float(colors[v, u] - colors.mean())
        # Noise of the filter's bandwidth moves a peak of width sigma by sigma over their ratio.
        sigma = self._filter.sigma / max(peak / (float(answer.std()) + LEAST_DIVISOR), 1.0)
        R = (sigma**2 + 1 / 12) * self._cell**2 * np.eye(2)  # known to a cell at least
        return Sighting(z, R, peak, contrast, glimpse)

    def likeness(self, seen: Sighting) -> float:
        """How like the target what is seen is, 0 to 1: the geometric mean of two witnesses.

        Each, peak and contrast, is a share of what it has been so far. Where colors never told the
        target from what is around it, the peak is the only one.
        """
        share = np.clip(
            np.array([seen.peak, seen.contrast]) / np.maximum(self._usual, LEAST_DIVISOR), 0, 1
        )
        return float(np.sqrt(share.prod()) if self._usual[1] > LEAST_CONTRAST else share[0])

    def is_sure(self, seen: Sighting) -> bool:
        """Whether it is so like the target that it may be learned; the first frames have to be."""
        least = NEARBY if self._sightings < USUAL_FRAMES else LEARNED
        return self.likeness(seen) >= least

    def partly(self, seen: Sighting) -> Sighting:
        """What is seen as a part of the target: nobody knows which.

        The middle of a part, a share s of the target along one axis, is (1 - s) / 2 of its size
        beside the middle at most, and half of that in the mean of all places of the part.
        """
        share = min(max(seen.peak, 0) / max(float(self._usual[0]), LEAST_DIVISOR), 1)
        return seen._replace(R=seen.R + np.diag(((1 - share) / 4 * self.size) ** 2))

    def resize(self, frame: Frame, center: Floats) -> None:
        """Find the size of the target around its center (u, v) [px]."""
        self._scale.update(frame, center)

    def learn(self, frame: Frame, center: Floats, seen: Sighting | None) -> None:
        """Learn what the target looks like around its center (u, v) [px].

        :param seen: how clearly it was seen in this frame, if it was; what was looked at is learned
            from if the target is nearly in its middle.
        """
        if seen is None or (np.abs(center - seen.glimpse.center) > CENTERED * self._cell).any():
            glimpse = self._glimpse(frame, center)
        else:
            glimpse = seen.glimpse
        self._filter.learn(glimpse.spectrum, (center - glimpse.center) / self._cell)
        self._colors.learn(glimpse.patch)
        if seen is not None:
            self._sightings += 1
            new = np.array([seen.peak, seen.contrast])
            self._usual += (new - self._usual) / min(self._sightings, USUAL_FRAMES)

    @property
    def _cell(self) -> float:
        """Side of a cell now [px]."""
        return self._pitch * self._scale.scale

    def _glimpse(self, frame: Frame, center: Floats) -> Glimpse:
        patch = self._patch(frame, center)
        spectrum = self._filter.transform(describe(patch, frame.encoding))
        return Glimpse(np.array(center), patch, spectrum)

    def _patch(self, frame: Frame, center: Floats) -> Pixels:
        region = self._cells * self._cell
        return sample(frame, center, region, tuple((self._cells * CELL).tolist()))
