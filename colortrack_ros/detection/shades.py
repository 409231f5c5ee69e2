"""The shades of a thing beyond the gap where its color ends: they lie on the thing, nowhere else.

A thing has a light and a dark side, and its light changes. Such colors are outside of the ellipsoid
that ends in the first gap (extent.py), but in the picture they are right beside what is inside.
"""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.cells import cell_bounds
from colortrack_ros.detection.cells import CELLS
from colortrack_ros.detection.color_table import look_up
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.extent import HALF_WAY
from colortrack_ros.detection.extent import MOST_GROWTH
from colortrack_ros.detection.extent import SIZE_STEP
from colortrack_ros.detection.extent import SLOPE_STEPS

ELSEWHERE_SHARE = 0.01
"""Pixels elsewhere that a color may take in with its shades [share of those that it has]: on four
real clips, by `python benchmark/colors.py --constants`, half and twice of it change recall by at
most 1 point, and twice the IoU of boxes of caps from 0.83 to 0.86."""

OUTSIDE = 2
"""Width of the outline of a thing, on either side of which is a pixel of the sample [px]."""

REACHES = np.exp(SIZE_STEP * np.arange(-SLOPE_STEPS, np.log(HALF_WAY) / SIZE_STEP + SLOPE_STEPS))
"""Half axes that are tried over those of the gap, and what the growth at both ends is taken over.
The gap is half-way to what is around at most, so that is where the last one ends."""


def reach_of(
    cells: NDArray[np.uint16], counts: NDArray[np.float64], extent: Extent
) -> float | None:
    """By how much the half axes may grow for the shades, 1 to HALF_WAY; None if no thing is seen.

    They may as long as the count grows no more than in a gap, and what is added is at most as far
    from the things as those are thick, but for ELSEWHERE_SHARE.

    :param cells, counts: (H, W) and (65536,) of :func:`sample_colors`.
    """
    (filled,) = counts.nonzero()
    away = (cell_bounds()[0].T[filled] - extent.lab) / extent.axes
    distance = np.sqrt((away**2).sum(axis=1))
    beside = _beside(cells, filled[distance < 1])
    if beside is None:
        return None
    order = np.argsort(distance)
    behind = np.searchsorted(distance[order], REACHES)
    number = counts[filled[order]]
    apart = number - beside[filled[order]] * (counts.sum() / cells.size)
    sums = np.stack([number, apart]).cumsum(axis=1)
    count, elsewhere = np.hstack([np.zeros((2, 1)), sums])[:, behind]
    tried = slice(SLOPE_STEPS, -SLOPE_STEPS)
    growth = (count[2 * SLOPE_STEPS :] - count[: -2 * SLOPE_STEPS]) / np.maximum(count[tried], 1)
    growth /= 2 * SLOPE_STEPS * SIZE_STEP
    count, elsewhere = count[tried], elsewhere[tried]
    ends = (growth > MOST_GROWTH) | (elsewhere - elsewhere[0] > ELSEWHERE_SHARE * count[0])
    last = int(np.append(ends[1:], True).argmax())
    return float(REACHES[tried][last])


def _beside(cells: NDArray[np.uint16], mine: NDArray[np.intp]) -> NDArray[np.intp] | None:
    """(65536,) pixels in and around the things, at most as far from them as they are thick.

    None when there are no things, but for specks.

    :param mine: cells of the color.
    """
    inside = np.zeros(CELLS, np.uint8)
    inside[mine] = 1
    own = np.empty(cells.shape, np.uint8)
    look_up(inside, cells, own)
    things = cv2.erode(own, np.ones((3, 3), np.uint8))
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
    """The extent, its half axes so much longer."""
    dL, da, db = (reach * axis for axis in extent.axes)
    return replace(extent, axes=(dL, da, db))
