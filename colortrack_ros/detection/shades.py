"""Further shades of an object, beyond the gap where its color ends.

An object has a light and a dark side, and its light changes. The colors of these shades are outside
the ellipsoid that ends in the first gap (extent.py), but in the picture they are adjacent to the
colors inside. Near the color, a larger ellipsoid covers them; farther away, more ellipsoids along
the line of shades do.
"""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.cells import CELLS
from colortrack_ros.detection.cells import lab_of_cells
from colortrack_ros.detection.color_table import look_up
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.extent import LARGEST_SHARE
from colortrack_ros.detection.growth import HALF_WAY
from colortrack_ros.detection.growth import MOST_GROWTH
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.growth import NO_LIGHT
from colortrack_ros.detection.growth import SIZE_STEP
from colortrack_ros.detection.growth import SLOPE_STEPS
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.morphology import EROSION

ELSEWHERE_SHARE = 0.01
"""Number of pixels elsewhere that the shades of a color may include [share of the color's pixels].
On four real clips, `python benchmark/colors.py --constants`, half and twice of it change recall by
at most 1 point, and twice changes the IoU of boxes of caps from 0.83 to 0.86."""

OUTSIDE = 2
"""Width of an object's outline, which has one pixel of the sample on each side [px]."""

REACHES = np.exp(SIZE_STEP * np.arange(-SLOPE_STEPS, np.log(HALF_WAY) / SIZE_STEP + SLOPE_STEPS))
"""Half axes to try, relative to those of the gap, and the margins for the growth at both ends. The
gap is at most half-way to the surroundings, so the last one ends there."""


AT_OBJECT = 0.1
"""Least share of the pixels of a shade that are connected to an object of the color itself.
Otherwise the shades lead over to another object, of which each one adds a shell that is too thin to
count. `python benchmark/one_pixel.py`, wheels: 180 of 192 pixels are right, also with half or twice
of it, 158 without. With three times, a blue ball beside blue folders is lost by its dark pixel."""

SHADE_STEP, MOST_SHADES = 0.5, 24
"""Step from one shade to the next [half axes], and the maximum number of steps to each side. Every
second one is kept: ellipsoids one half axis apart form a tube of at least 0.87 times their width.
Assumed: by `python benchmark/colors.py --constants SHADE_STEP`, half of the step, with the same
gap, costs a third of the cups, and twice adds no shades to any of the four clips."""

SHADE_GAP = 0.15
"""Pixels that a shade adds where the shades end [share of those before it]. Assumed: by `python
benchmark/colors.py --constants SHADE_GAP`, half changes no recall, and twice changes that of cups
by -7 points. The IoU of boxes of caps is 0.83 and 0.96, compared to 0.87 with it."""


def reach_of(
    cells: NDArray[np.uint16], counts: NDArray[np.float64], extent: Extent, apart: list[Triple]
) -> float | None:
    """Factor by which shades extend the half axes, 1 to HALF_WAY; None if no object is visible.

    They grow as long as the count grows no more than in a gap. Except for ELSEWHERE_SHARE, the
    added pixels must be no farther from the objects than those are thick.

    :param cells, counts: (H, W) and (65536,) of :func:`sample_colors`.
    :param apart: colors that other objects have, which are left outside.
    """
    (filled,) = counts.nonzero()
    away = (lab_of_cells(filled) - extent.lab) / extent.axes
    distance = np.sqrt((away**2).sum(axis=1))
    beside = _beside(cells, filled[distance < 1])
    if beside is None:
        return None
    order = np.argsort(distance)
    behind = np.searchsorted(distance[order], REACHES)
    number = counts[filled[order]]
    far = number - beside[filled[order]] * (counts.sum() / cells.size)
    sums = np.stack([number, far]).cumsum(axis=1)
    count, elsewhere = np.hstack([np.zeros((2, 1)), sums])[:, behind]
    tried = slice(SLOPE_STEPS, -SLOPE_STEPS)
    growth = (count[2 * SLOPE_STEPS :] - count[: -2 * SLOPE_STEPS]) / np.maximum(count[tried], 1)
    growth /= 2 * SLOPE_STEPS * SIZE_STEP
    count, elsewhere = count[tried], elsewhere[tried]
    ends = (growth > MOST_GROWTH) | (elsewhere - elsewhere[0] > ELSEWHERE_SHARE * count[0])
    ends |= REACHES[tried] >= nearest_sample(np.array([extent.lab]), apart, np.array(extent.axes))
    last = int(np.append(ends[1:], True).argmax())
    return float(REACHES[tried][last])


def _beside(cells: NDArray[np.uint16], mine: NDArray[np.intp]) -> NDArray[np.intp] | None:
    """(65536,) pixels in and near the objects, no farther away than those are thick.

    None if there are only specks.

    :param mine: cells of the color.
    """
    inside = np.zeros(CELLS, np.uint8)
    inside[mine] = 1
    own = np.empty(cells.shape, np.uint8)
    look_up(inside, cells, own)
    things = cv2.erode(own, EROSION)
    left, top, width, height = cv2.boundingRect(things)
    if not width:
        return None
    part = slice(top, top + height), slice(left, left + width)
    margin = OUTSIDE + int(cv2.distanceTransform(things[part], cv2.DIST_L2, 3).max())
    part = (
        slice(max(top - margin, 0), top + height + margin),
        slice(max(left - margin, 0), left + width + margin),
    )
    away = cv2.distanceTransform(1 - things[part], cv2.DIST_L2, 3)
    return np.bincount(cells[part][away < margin], minlength=CELLS)


def with_shades(extent: Extent, reach: float) -> Extent:
    """The extent with its half axes multiplied by reach."""
    dL, da, db = (reach * axis for axis in extent.axes)
    return replace(extent, axes=(dL, da, db))


def shades_beyond(
    cells: NDArray[np.uint16], counts: NDArray[np.float64], extent: Extent, apart: list[Triple]
) -> tuple[Triple, ...]:
    """Centers of additional ellipsoids for lighter and darker shades of a color.

    Each is a step ahead on the ridge of the color's own pixels. They end at the last gap before one
    that doubles these, covers too much of the picture, includes an object not connected to them, or
    reaches gray or another color.

    :param cells, counts: (H, W) and (65536,) of :func:`sample_colors`.
    :param apart: colors that other objects have, which are left outside.
    """
    (filled,) = counts.nonzero()
    color, number = lab_of_cells(filled), counts[filled] * (cells.size / counts.sum())
    center, axes = np.array(extent.lab), np.array(extent.axes)
    mine = core = _within(color, center, axes)
    found = list[Triple]()
    for way in (center - NO_LIGHT, NO_LIGHT - center):
        shades, last, has = list[Triple](), center, mine
        ended: tuple[list[Triple], NDArray[np.bool_]] = [], mine
        for _ in range(MOST_SHADES):
            way = way * SHADE_STEP / np.linalg.norm(way / axes)
            shade = last + way
            if not _is_shade(shade, axes, apart):
                break
            added = _within(color, shade, axes) & ~has
            more, before = number[added].sum(), number[has].sum()
            if more <= SHADE_GAP * before:
                ended = shades.copy(), has
            if not 0 < more <= before or before + more > LARGEST_SHARE * cells.size:
                break
            each = filled[core], filled[has & ~core], filled[added]
            if not _is_at_objects(cells, *each, most_apart=ELSEWHERE_SHARE * before):
                break
            way = np.average(color[added], axis=0, weights=number[added]) - last
            last, has = shade, has | added
            shades.append((float(shade[0]), float(shade[1]), float(shade[2])))
        found, mine = found + ended[0][::-2], ended[1]
    return tuple(found)


def _is_shade(shade: NDArray[np.float64], axes: NDArray[np.float64], apart: list[Triple]) -> bool:
    """Whether an ellipsoid with this center includes neither gray nor another color."""
    is_gray = np.hypot(*(shade / axes)[1:]) < 1
    is_another = nearest_sample(shade[None], apart, axes)[0] < 1
    return bool(not is_gray and not is_another and 0 <= shade[0] <= 100)


def _within(
    color: NDArray[np.float64], center: NDArray[np.float64], axes: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """(N,) whether colors are inside an ellipsoid."""
    return np.asarray((((color - center) / axes) ** 2).sum(axis=1) < 1)


def _is_at_objects(
    cells: NDArray[np.uint16],
    core: NDArray[np.intp],
    joined: NDArray[np.intp],
    added: NDArray[np.intp],
    most_apart: float,
) -> bool:
    """Whether the pixels of a shade are those of the objects, of which some have the color itself.

    :param core, joined, added: cells of the color, of the shades that it includes, and of the next.
    :param most_apart: number of object pixels, without outlines, that may be elsewhere.
    """
    kind = np.zeros(CELLS, np.uint8)
    kind[added], kind[joined], kind[core] = 1, 2, 3
    label = np.empty(cells.shape, np.uint8)
    look_up(kind, cells, label)
    count, component = cv2.connectedComponents(label)
    inner = component[cv2.erode(label, EROSION) > 0]
    if np.count_nonzero(~_include(component, label >= 2, count)[inner]) > most_apart:
        return False
    new = component[label == 1]
    return int(np.count_nonzero(_include(component, label == 3, count)[new])) > AT_OBJECT * len(new)


def _include(component: Any, own: NDArray[np.bool_], count: int) -> NDArray[np.bool_]:
    """(count,) which components include more of some pixels than outlines."""
    found = np.zeros(count, bool)
    found[component[cv2.erode(own.view(np.uint8), EROSION) > 0]] = True
    return found
