"""Appearance: what distinguishes a target from its surroundings, learned while it is clearly seen.

A template asks whether a window is the same, which fails for targets that deform. An appearance
asks whether a place looks more like the target than all places around it do, by the response of a
correlation filter and by colors (Staple, Bertinetto et al. 2016).
"""

from typing import NamedTuple

import cv2
import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.estimation.box_centers import variance_of_part
from colortrack_ros.windows.colors import Colors
from colortrack_ros.windows.colors import mean_inside
from colortrack_ros.windows.correlation import CorrelationFilter
from colortrack_ros.windows.correlation import Spectrum
from colortrack_ros.windows.features import CELL
from colortrack_ros.windows.features import cut
from colortrack_ros.windows.features import Cutout
from colortrack_ros.windows.features import describe
from colortrack_ros.windows.features import Features
from colortrack_ros.windows.features import Pixels
from colortrack_ros.windows.peaks import vertex
from colortrack_ros.windows.scale import ScaleFilter

SURROUNDINGS = 1.5
"""Margin of the region around the target, as a share of its mean side: a square target has a search
region 2.5 times as wide (Henriques et al. 2015, 7)."""

LEAST_SURROUNDINGS = 24.0
"""Least margin [px]: 12 on either side, one standard deviation of the motion of a new target per
frame (initial_speed, at 25 frames/s)."""

SIDE = 32
"""Cells of that region, in the mean of width and height; 37 in Staple. 32 is fast to transform."""

COLOR_SHARE = 0.3
"""Weight of colors in the response (Bertinetto et al. 2016, table 1)."""

NEARNESS = 0.176
"""Share of the response that is taken off at the rim; nothing is taken off at the expected place
(Bertinetto et al. 2016, "Fully-convolutional Siamese networks", window influence)."""

LEAST_CONTRAST = 0.1
"""Least usual contrast at which colors distinguish a target from its surroundings. On ten public
sequences it is 0.16 to 0.5."""

NEARBY, LEARNED, RARER = 0.55, 0.7, 0.1
"""Least likeness of a target near its expected place, and of one to learn from. One in 20 and one
in 100 other places reach them; 2 and 30 in 1,000 looks at the target do not. For each RARER of
likeness there are e times fewer such places (``benchmark/likeness.py FOLDER``)."""

LEAST_PEAK = 0.15
"""Least usual peak of a target that its filter distinguishes from its surroundings. On public
sequences one in 100 frames on the target has less, and one in 8 on nothing: a box of mostly floor,
or a window that slides from one thing to the next (benchmark/notes/windows.md)."""

FIRST_SHARE = 0.5
"""Initial usual peak and contrast, as a share of those in the first frame. On ten public sequences
the next frame has 0.5 to 1 of them."""

USUAL_FRAMES = 10
"""Memory of the means of peak and contrast [frames]. Assumed: a third of a second."""

LEAST_CELLS = 8
"""Least width and height of a region in cells: the width of the filter's peak, and as much on
either side."""

LEAST_DISTRACTOR, DISTRACTOR_DISTANCE = 0.25, 0.75
"""Least response of a distractor, as a share of that of the target, and its least distance from it
along either axis, as a share of the size. Assumed: one walker answers 0.2 to 0.5 to the filter of
another (benchmark/notes/windows.md), and those who walk side by side overlap a little."""

CROWDED = 1.6
"""Multiple of its usual share from which on what responds beside a target is about to cover it.
Chosen on 20 of 52 public sequences with masks and people (benchmark/notes/windows.md)."""

CENTERED = 1.0
"""Largest offset of a target from the center of a glimpse that is learned from [cells]. Derived:
INNER leaves 1.3 cells of a square target on either side."""

LEAST_DIVISOR = 1e-6
"""Lower bound of divisors, against division by zero."""


class Glimpse(NamedTuple):
    """A part of a frame in which the target was searched.

    center: (u, v) [px]; cell: width and height of a cell [px]; patch: its pixels; spectrum: see
    CorrelationFilter.transform.
    """

    center: Floats
    cell: Floats
    patch: Pixels
    spectrum: Spectrum


class Sighting(NamedTuple):
    """Where the target seems to be.

    z: (u, v) [px]; R: (2, 2) its covariance [px^2]; peak: height of the response there; contrast:
    likelihood of the target's colors there, less its mean over the glimpse, -1 to 1; glimpse: what
    was searched; answer: (rows, columns) the response.
    """

    z: Floats
    R: Floats
    peak: float
    contrast: float
    glimpse: Glimpse
    answer: Features


class Appearance:
    """Appearance of one target.

    :param center: u, v [px].
    :param size: its width and height [px].
    """

    def __init__(self, frame: Frame, center: Floats, size: Floats) -> None:
        region = size + max(SURROUNDINGS * size.mean(), LEAST_SURROUNDINGS)
        self._pitch = float(np.sqrt(region.prod())) / SIDE
        cells = np.maximum(np.rint(region / self._pitch).astype(int), LEAST_CELLS)
        self._cells = np.minimum(cells, 2 * SIDE) | 1  # odd: one is in the middle
        self._size, self._target = size, size / self._pitch
        self._scale = ScaleFilter(frame, center, size)
        part = self._part(frame, center)
        patch, place = self._resampled(part), (center - part.center) / (part.size / self._cells)
        self._filter = CorrelationFilter(describe(patch, frame.encoding), self._target, place)
        self._nearness = 1 - NEARNESS * (1 - self._filter.window)
        self._colors = Colors(patch, self._target * CELL)
        self._sightings = 0
        first = self.look(frame, center)
        self._usual = FIRST_SHARE * np.array([first.peak, first.contrast])
        self._usual_share = self._beside(center, first)[0]

    @property
    def size(self) -> Floats:
        """Current width and height [px]."""
        return np.asarray(self._size * self._scale.scale)

    @property
    def reach(self) -> Floats:
        """How far from a center look() finds a target, by u and v [px]."""
        return np.asarray(self._cells * self._cell / 2 - self.size / 4)

    @property
    def is_distinct(self) -> bool:
        """Whether the filter usually answers to the target, as it does to what stays itself."""
        return bool(self._usual[0] >= LEAST_PEAK)

    def look(self, frame: Frame, center: Floats) -> Sighting:
        """Look for the target around a center (u, v) [px]."""
        glimpse = self._glimpse(frame, center)
        answer = self._filter.respond(glimpse.spectrum)
        likely = self._colors.likelihood(glimpse.patch)
        colors = mean_inside(likely, answer.shape[::-1], self._target)
        both = (1 - COLOR_SHARE) * answer + COLOR_SHARE * colors
        both *= self._nearness
        v, u = np.unravel_index(int(both.argmax()), both.shape)
        cell = np.array([vertex(both[v], int(u)), vertex(both[:, u], int(v))])
        z = glimpse.center + (cell - self._cells // 2) * glimpse.cell
        peak, contrast = float(answer[v, u]), float(colors[v, u] - colors.mean())
        # Noise in the filter's bandwidth shifts a peak of width sigma by sigma / (peak / noise).
        sigma = self._filter.sigma / max(peak / (float(answer.std()) + LEAST_DIVISOR), 1.0)
        R = (sigma**2 + 1 / 12) * self._cell**2 * np.eye(2)  # quantized to a cell
        return Sighting(z, R, peak, contrast, glimpse, answer)

    def likeness(self, seen: Sighting) -> float:
        """How much a sighting resembles the target, 0 to 1: the geometric mean of two ratios.

        Peak and contrast are each divided by their usual values. If colors never distinguished the
        target from its surroundings, the peak alone counts.
        """
        peak, contrast = self._usual.tolist()
        by_peak = min(max(seen.peak / max(peak, LEAST_DIVISOR), 0.0), 1.0)
        if contrast <= LEAST_CONTRAST:
            return by_peak
        return float(np.sqrt(by_peak * min(max(seen.contrast / contrast, 0.0), 1.0)))

    def is_sure(self, seen: Sighting) -> bool:
        """Whether a sighting is clear enough to learn from; NEARBY suffices at first."""
        least = NEARBY if self._sightings < USUAL_FRAMES else LEARNED
        return self.likeness(seen) >= least

    def partly(self, seen: Sighting) -> Sighting:
        """The sighting as that of an unknown part of the target, with a larger covariance."""
        share = min(max(seen.peak, 0) / max(float(self._usual[0]), LEAST_DIVISOR), 1)
        return seen._replace(R=seen.R + np.diag(variance_of_part(share, self.size)))

    def resize(self, frame: Frame, center: Floats) -> None:
        """Estimate the size of the target around its center (u, v) [px]."""
        self._scale.update(frame, center)

    def learn(self, frame: Frame, center: Floats, seen: Sighting | None) -> None:
        """Learn the appearance of the target around its center (u, v) [px].

        Nothing is learned while more than usual responds beside it: somebody who crosses or covers
        it is part of what is seen then, and would be taken for it in the end.

        :param seen: how clearly the target was seen in this frame, if at all. Its glimpse is
            learned if the target is close to the glimpse's center.
        """
        share, place = (0.0, center) if seen is None else self._beside(center, seen)
        if seen is not None and self._is_crowded(share):
            return
        if seen is None or (np.abs(center - seen.glimpse.center) > CENTERED * self._cell).any():
            glimpse = self._glimpse(frame, center)
        else:
            glimpse = seen.glimpse
        if share >= LEAST_DISTRACTOR:
            other = self._glimpse(frame, place)
            self._filter.unlearn(other.spectrum, (place - other.center) / other.cell)
        self._filter.learn(glimpse.spectrum, (center - glimpse.center) / glimpse.cell)
        self._colors.learn(glimpse.patch)
        if seen is not None:
            self._sightings += 1
            new = np.array([seen.peak, seen.contrast])
            self._usual += (new - self._usual) / min(self._sightings, USUAL_FRAMES)

    def _is_crowded(self, share: float) -> bool:
        """Return whether more than usual responds beside the target; note what is usual."""
        crowded = share > CROWDED * max(self._usual_share, LEAST_DISTRACTOR)
        rate = 1 / min(self._sightings + 1, USUAL_FRAMES)
        self._usual_share += rate * (share - self._usual_share)
        return crowded

    def _beside(self, center: Floats, seen: Sighting) -> tuple[float, Floats]:
        """Return what responds most beside the target, as a share of it up to 1, and where."""
        rows, columns = seen.answer.shape
        middle = self._cells // 2 + (center - seen.glimpse.center) / seen.glimpse.cell
        beside_u, beside_v = (
            np.abs(np.arange(n) - at) >= DISTRACTOR_DISTANCE * side
            for n, at, side in zip((columns, rows), middle, self._target, strict=True)
        )
        others = np.where(beside_v[:, None] | beside_u, seen.answer, -1.0)
        v, u = np.unravel_index(int(others.argmax()), others.shape)
        place = seen.glimpse.center + ((u, v) - self._cells // 2) * seen.glimpse.cell
        return min(float(others[v, u]) / max(seen.peak, LEAST_DIVISOR), 1.0), place

    @property
    def _cell(self) -> float:
        """Current side of a cell [px]."""
        return self._pitch * self._scale.scale

    def _glimpse(self, frame: Frame, center: Floats) -> Glimpse:
        part = self._part(frame, center)
        patch = self._resampled(part)
        spectrum = self._filter.transform(describe(patch, frame.encoding))
        return Glimpse(part.center, part.size / self._cells, patch, spectrum)

    def _part(self, frame: Frame, center: Floats) -> Cutout:
        return cut(frame, center, self._cells * self._cell, self._cell / CELL)

    def _resampled(self, part: Cutout) -> Pixels:
        return np.asarray(cv2.resize(part.pixels, tuple((self._cells * CELL).tolist())), np.uint8)
