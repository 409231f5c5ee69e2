"""Strangers: things of another hue that the extent of a color includes.

Where nothing but a red and an orange ball is in the picture, the gap around the colors of both is
as deep as that around those of one, and wider. What tells them apart is that no pixel of the one
touches the other, while a highlight or a dark side does.
"""

from collections.abc import Callable
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.cells import cell_bounds
from colortrack_ros.detection.cells import CELLS
from colortrack_ros.detection.cells import lab_of_cells
from colortrack_ros.detection.color_table import look_up
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.extent import find_extent
from colortrack_ros.detection.extent import SHAPE
from colortrack_ros.detection.growth import FEWEST_PIXELS
from colortrack_ros.detection.growth import MOST_GROWTH
from colortrack_ros.detection.growth import NEAR
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.light_change import lab_in_light
from colortrack_ros.detection.morphology import EROSION
from colortrack_ros.detection.usual_areas import LEAST_SHARE

OTHER_HUE = np.radians(15.0)
"""Least difference of the mean hues of two things of different colors: those of red and orange
drawn balls are 25 degrees apart, and those of wheels of 16 hues 23 on average."""

MOST_ROUNDS = 4
"""Most searches for an extent, each without the strangers of the last one. Assumed: more further
hues are not in one gap."""

OWN_LEFT = 1 / 2
"""Least share of its own pixels that a color must have for the others to be judged: else, a hand
may be before the ball, and a cap of about its hue all that is left. As LEAST_PRESENT."""


class Strangers:
    """The strangers of one color so far.

    :param apart: colors that other objects are known to have.

    apart: the colors to leave outside: these, and those of the strangers.
    """

    def __init__(self, apart: Sequence[Triple] = ()) -> None:
        self.apart = list(apart)
        self._own = 0

    def relight(self, light: NDArray[np.float64]) -> None:
        """Follow a change of the light; light: (3,) factors of linear red, green, and blue."""
        self.apart = [lab_in_light(lab, light) for lab in self.apart]

    def part(
        self,
        cells: NDArray[np.uint16],
        counts: NDArray[np.float64],
        lab: Triple,
        extent: Extent,
        find: Callable[[], Extent | None],
    ) -> Extent:
        """The extent of a color, found anew as long as it includes strangers.

        :param cells, counts: (H, W) and (65536,) of :func:`sample_colors`.
        :param lab: the color, or one within it.
        :param extent: as found; it is returned if it includes none.
        :param find: finds the extent that leaves the colors apart outside.
        """
        for _ in range(MOST_ROUNDS):
            mean = self._included(cells, counts, lab, extent)
            new = mean[nearest_sample(mean, self.apart, SHAPE) > NEAR]
            if not len(new):
                break
            self.apart += [(L, a, b) for L, a, b in new.tolist()]
            extent = find() or extent
        return extent

    def _included(
        self,
        cells: NDArray[np.uint16],
        counts: NDArray[np.float64],
        lab: Triple,
        extent: Extent,
    ) -> NDArray[np.float64]:
        """(K, 3) mean colors in CIELAB of the strangers that an extent includes.

        They are as large as an object, wholly in the picture, have no pixels of the color itself,
        and are of another hue than what has some: equal things may be in different light. Where
        the color has no gap, or most of its pixels are away, there are none.
        """
        none = np.zeros((0, 3))
        if extent.growth > MOST_GROWTH:
            return none
        label = label_extent(cells, counts, lab, extent)
        count, thing, box, _ = cv2.connectedComponentsWithStats(cv2.erode(label, EROSION))
        size = box[:, cv2.CC_STAT_AREA].astype(np.intp)
        core = np.bincount(thing[label == 2], minlength=count)
        own = core >= FEWEST_PIXELS
        own[0] = False
        pixels, cut = int(size[own].sum()), _is_cut(box, cells.shape)
        if not pixels or pixels < OWN_LEFT * self._own:
            return none
        self._own = max(pixels, self._own * bool(cut[own].any()))
        other = ~own & ~cut & (size >= max(FEWEST_PIXELS, LEAST_SHARE * size[own].max()))
        if not other[1:].any():
            return none
        inside = thing > 0
        of, cell = thing[inside], cells[inside]
        total = [np.bincount(of, axis[cell], count) for axis in cell_bounds()[0]]
        mean = np.stack(total, axis=1) / size[:, None]
        return np.asarray(mean[other & _is_other_hue(mean, size[own] @ mean[own] / pixels)])


def find_own_extent(
    cells: NDArray[np.uint16],
    counts: NDArray[np.float64],
    lab: Triple,
    apart: Sequence[Triple] = (),
) -> tuple[Extent | None, list[Triple]]:
    """Find the extent of a color in one picture without strangers, and the colors outside it.

    :param cells, counts: (H, W) and (65536,) of :func:`sample_colors`.
    :param lab, apart: as for :func:`find_extent`.
    """
    strangers = Strangers(apart)

    def find() -> Extent | None:
        return find_extent(counts, lab, apart=strangers.apart)

    extent = find()
    return extent and strangers.part(cells, counts, lab, extent, find), strangers.apart


def label_extent(
    cells: NDArray[np.uint16], counts: NDArray[np.float64], lab: Triple, extent: Extent
) -> NDArray[np.uint8]:
    """(H, W) 0 outside an extent, 1 inside, and 2 for the color itself."""
    (filled,) = counts.nonzero()
    color = lab_of_cells(filled)
    kind = np.zeros(CELLS, np.uint8)
    kind[filled[nearest_sample(color, (extent.lab,), np.array(extent.axes)) < 1]] = 1
    kind[filled[nearest_sample(color, (lab,), SHAPE) < NEAR]] *= 2
    label = np.empty(cells.shape, np.uint8)
    look_up(kind, cells, label)
    return label


def _is_cut(box: Any, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """(N,) whether the picture's border cuts things, which may have all colors beyond it.

    :param box: (N, 5) of their eroded pixels: left, top, width, height, area.
    """
    low, high = box[:, :2], box[:, :2] + box[:, 2:4]
    return np.asarray(((low <= 1) | (high >= np.array(shape[::-1]) - 1)).any(axis=1))


def _is_other_hue(lab: NDArray[np.float64], own: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,) whether colors, (N, 3), have another hue than the own one, and are not near its ray."""
    a, b = lab[:, 1:].T
    along, across = own[1] * a + own[2] * b, own[1] * b - own[2] * a
    away = np.where(along > 0, np.abs(across) / np.hypot(*own[1:]), np.hypot(a, b))
    return np.asarray((np.abs(np.arctan2(across, along)) > OTHER_HUE) & (away > NEAR))
