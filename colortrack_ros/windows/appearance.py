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
from colortrack_ros.windows.features import CELL
from colortrack_ros.windows.features import describe
from colortrack_ros.windows.features import Features
from colortrack_ros.windows.features import Floats
from colortrack_ros.windows.features import Pixels
from colortrack_ros.windows.features import sample
from colortrack_ros.windows.scale import ScaleFilter

SURROUNDINGS = 1.5
"""Width of what is looked at around the target, as a share of the mean of its width and height: a
square target is searched in a region 2.5 times as wide (Henriques et al. 2015, 7)."""

SIDE = 32
"""Cells of that region, in the mean of width and height; 37 in Staple. Fast to transform."""

COLOR_SHARE = 0.3
"""Of colors in the answer (Bertinetto et al. 2016, table 1)."""

LEAST_CLEARNESS, COLORS_SAY = 10.0, 2.0
"""Clearness, times the share of its usual contrast, that the target has at least: between the 20 of
a strong peak and the 7 of what is covered or lost (the ratio of peak and sidelobes of Bolme et al.
2010, 3.5). Where there are colors as a second witness, half of it."""

LEAST_CONTRAST = 0.1
"""Usual contrast of a target whose colors tell it from what is around it."""

LEAST_PEAK, LEAST_SHARPNESS = 0.6, 0.45
"""Of their means so far, at least, where the target is wholly in view: only then is it learned
(Wang, Liu and Huang 2017, 4.1)."""

PEAK_MEMORY = 10
"""Frames that the means go back."""

PEAK_CELLS = 3
"""Cells beside the peak that count as it."""


class Sighting(NamedTuple):
    """Where the target seems to be.

    z: (u, v) [px]; R: (2, 2) its covariance [px^2]; peak: height of the answer there; sharpness:
    the peak's energy by the mean of all (APCE of Wang, Liu and Huang 2017, (9)); clearness: the
    peak by the standard deviation of what is beside it; contrast: how much likelier the colors
    there are the target's than those of all that was looked at, -1 to 1.
    """

    z: Floats
    R: Floats
    peak: float
    sharpness: float
    clearness: float
    contrast: float


class Appearance:
    """What one target looks like.

    :param center: u, v [px].
    :param size: its width and height [px].
    """

    def __init__(self, frame: Frame, center: Floats, size: Floats) -> None:
        region = size + SURROUNDINGS * size.mean()
        self._pitch = float(np.sqrt(region.prod())) / SIDE
        cells = np.maximum(np.rint(region / self._pitch).astype(int), 2 * PEAK_CELLS + 2)
        self._cells = np.minimum(cells, 2 * SIDE) | 1  # one is in the middle
        self._size, self._target = size, size / self._pitch
        self._scale = ScaleFilter(frame, center, size)
        patch = self._patch(frame, center)
        self._filter = CorrelationFilter(describe(patch, frame.encoding), self._target)
        self._colors = Colors(patch, self._target * CELL)
        self._least = LEAST_CLEARNESS / (COLORS_SAY if patch.ndim == 3 else 1)
        self._usual = np.zeros(3)
        self._sightings = 0
        self._usual[2] = self.look(frame, center).contrast

    @property
    def size(self) -> Floats:
        """Width and height [px] now."""
        return np.asarray(self._size * self._scale.scale)

    @property
    def reach(self) -> Floats:
        """How far around a center look() sees a target, by u and v [px]."""
        return np.asarray(self._cells * self._pitch * self._scale.scale / 2 - self.size / 4)

    def look(self, frame: Frame, center: Floats) -> Sighting:
        """Look for the target around a center (u, v) [px]."""
        patch = self._patch(frame, center)
        answer = self._filter.respond(describe(patch, frame.encoding))
        colors = mean_inside(self._colors.likelihood(patch), answer.shape[::-1], self._target)
        both = (1 - COLOR_SHARE) * answer + COLOR_SHARE * colors
        v, u = np.unravel_index(int(both.argmax()), both.shape)
        cell = np.array([u, v]) + _between(both, int(u), int(v))
        pitch = self._pitch * self._scale.scale
        z = center + (cell - self._cells // 2) * pitch
        low = float(answer.min())
        sharpness = (float(answer[v, u]) - low) ** 2 / float(np.mean((answer - low) ** 2) + 1e-12)
        clearness = _clearness(answer, int(u), int(v))
        # Noise of the filter's bandwidth moves a peak of width sigma by sigma over this.
        sigma = self._filter.sigma / max(clearness, 1.0)
        R = (sigma**2 + 1 / 12) * pitch**2 * np.eye(2)  # known to a cell at least
        return Sighting(
            z, R, float(answer[v, u]), sharpness, clearness, float(colors[v, u] - colors.mean())
        )

    def is_target(self, seen: Sighting) -> bool:
        """Whether it is the target rather than noise."""
        usual, share = self._usual[2], 1.0
        if usual > LEAST_CONTRAST:
            share = min(max(seen.contrast / usual, 0), 1)
        return seen.clearness * share >= self._least

    def is_whole(self, seen: Sighting) -> bool:
        """Whether what was seen is the target as clearly as it has been so far."""
        least = self._usual[:2] * [LEAST_PEAK, LEAST_SHARPNESS]
        if self._sightings < PEAK_MEMORY:  # a filter of one frame answers others less
            return self.is_target(seen)
        return self.is_target(seen) and bool(seen.peak >= least[0] and seen.sharpness >= least[1])

    def partly(self, seen: Sighting) -> Sighting:
        """What is seen as a part of the target: nobody knows which.

        The middle of a part, a share s of the target along one axis, is (1 - s) / 2 of its size
        beside the middle at most, and half of that in the mean of all places of the part.
        """
        share = min(seen.peak / max(float(self._usual[0]), 1e-6), 1)
        return seen._replace(R=seen.R + np.diag(((1 - share) / 4 * self.size) ** 2))

    def resize(self, frame: Frame, center: Floats) -> None:
        """Find the size of the target around its center (u, v) [px]."""
        self._scale.update(frame, center)

    def learn(self, frame: Frame, center: Floats, seen: Sighting | None) -> None:
        """Learn what the target looks like around its center (u, v) [px].

        :param seen: how clearly it was seen before, if it was.
        """
        patch = self._patch(frame, center)
        self._filter.learn(describe(patch, frame.encoding))
        self._colors.learn(patch)
        if seen is not None:
            self._sightings += 1
            new = np.array([seen.peak, seen.sharpness, seen.contrast])
            share = np.array([1 / min(self._sightings, PEAK_MEMORY)] * 2 + [1 / PEAK_MEMORY])
            self._usual += share * (new - self._usual)

    def _patch(self, frame: Frame, center: Floats) -> Pixels:
        region = self._cells * self._pitch * self._scale.scale
        return sample(frame, center, region, tuple((self._cells * CELL).tolist()))


def _clearness(answer: Features, u: int, v: int) -> float:
    """The peak by the standard deviation of what is beside it."""
    rest = answer.copy()
    near = slice(max(v - PEAK_CELLS, 0), v + PEAK_CELLS + 1)
    rest[near, max(u - PEAK_CELLS, 0) : u + PEAK_CELLS + 1] = np.nan
    return float((answer[v, u] - np.nanmean(rest)) / (np.nanstd(rest) + 1e-6))


def _between(surface: Features, u: int, v: int) -> Floats:
    """Where between the cells the peak is, by (u, v), from parabolas."""
    shift = np.zeros(2)
    for axis, line, k in ((0, surface[v], u), (1, surface[:, u], v)):
        if 0 < k < len(line) - 1:
            curvature = line[k - 1] + line[k + 1] - 2 * line[k]
            if curvature < 0:
                shift[axis] = np.clip((line[k - 1] - line[k + 1]) / (2 * curvature), -0.5, 0.5)
    return shift
