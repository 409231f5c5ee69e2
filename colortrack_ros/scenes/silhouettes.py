"""Things of any outline: polygons that rotate and change their size.

Like everything in a scene, their pictures are bit-identical on every machine.
"""

from dataclasses import dataclass
from dataclasses import field

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.scenes.curves import constant
from colortrack_ros.scenes.curves import Curve
from colortrack_ros.scenes.shapes import Ball
from colortrack_ros.scenes.shapes import UNIT
from colortrack_ros.scenes.texture import Color

LINES = 16
"""Lines in each row of pixels along which the covered part is exact: the error of the coverage is
at most 1/16."""

ARC = 24
"""Points on an arc: the error of a semicircle with a radius of 100 px is at most 0.23 px."""

PI = 3.141592653589793
"""Written out, so that a scene is bit-identical on every machine."""


@dataclass(frozen=True)
class Silhouette(Ball):
    """A plain polygon. Its radius is that of the disc of the same area, u and v are its centroid.

    :param outline: (P, 2) corners, of area pi around the centroid (0, 0); see :func:`normalized`.
    :param turn: tangent of half its angle of rotation to the right, over time.
    :param marks: polygons on it and their colors, in the same units.
    """

    outline: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    turn: Curve = field(default_factory=lambda: constant(0.0))
    marks: tuple[tuple[Floats, Color], ...] = ()


def normalized(points: ArrayLike) -> tuple[Floats, Floats, float]:
    """Return a polygon (P, 2) moved and scaled to area pi around (0, 0).

    :return: the polygon, its former centroid (2,), and the divisor.
    """
    p = np.asarray(points, float)
    q = np.concatenate([p[1:], p[:1]])
    cross = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    area = sum(cross.tolist()) / 2
    center = np.array([sum(column) for column in ((p + q) * cross[:, None]).T.tolist()])
    center /= 6 * area
    scale = float(np.sqrt(abs(area) / PI))
    return (p - center) / scale, center, scale


def arc(center: ArrayLike, radius: float, towards: tuple[float, float], reach: float) -> Floats:
    """Return ARC points on a circle, clockwise.

    :param towards: unit vector to the middle of the arc.
    :param reach: tangent of a quarter of the angle between the first and the last point.
    """
    t = reach * (2 * np.arange(ARC) / (ARC - 1) - 1)
    cosine, sine = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
    x, y = towards
    circle = np.stack([cosine * x - sine * y, cosine * y + sine * x], axis=1)
    return np.asarray(center, float) + radius * circle


def placed(points: Floats, center: Floats, radius: float, turn: float) -> Floats:
    """Return points of a silhouette in the picture, (P, 2) [px]."""
    cosine, sine = (1 - turn * turn) / (1 + turn * turn), 2 * turn / (1 + turn * turn)
    x, y = points[:, 0] * radius, points[:, 1] * radius
    return np.stack([center[0] + cosine * x - sine * y, center[1] + sine * x + cosine * y], axis=1)


def draw_polygon(image: NDArray[np.uint8], corners: Floats, color: ArrayLike) -> None:
    """Draw a simple polygon, anti-aliased, in place, without motion blur.

    :param image: (H, W, 3) BGR.
    :param corners: (P, 2) u, v [px].
    :param color: (3,) BGR.
    """
    box, covered = _covered(image, corners)
    patch = image[box]
    whole = covered[..., None] * np.rint(color).astype(np.int32)
    patch[:] = (patch * (UNIT - covered)[..., None] + whole + UNIT // 2) // UNIT


def paint_polygon(mask: NDArray[np.uint8], corners: Floats, value: int) -> None:
    """Set the pixels of the mask (H, W) that are at least half in the polygon."""
    box, covered = _covered(mask, corners)
    mask[box][2 * covered >= UNIT] = value


def _covered(image: NDArray, corners: Floats) -> tuple[tuple[slice, slice], NDArray[np.int32]]:
    """Return the pixels that a polygon may touch, and the covered share of each in UNIT.

    A side that goes down covers everything to its right, one that goes up uncovers it: exact along
    each of the LINES in a row of pixels.
    """
    size = np.array(image.shape[1::-1])
    first = np.clip(np.floor(corners.min(axis=0) + 0.5), 0, size).astype(int)
    last = np.clip(np.floor(corners.max(axis=0) + 0.5) + 1, first, size).astype(int)
    width, height = last - first
    box = slice(first[1], last[1]), slice(first[0], last[0])
    y = (np.arange(height * LINES) + 0.5) / LINES + (first[1] - 0.5)
    line, x, down = _crossings(corners, y)
    x = np.clip(x - (first[0] - 0.5), 0, width)
    pixel = x.astype(int)
    left = down * (pixel + 1 - x)
    # all at once and in place, since these are megabytes; the sums are bit-identical
    index = (line * (width + 2) + pixel)[:, None] + [0, 1]
    sides = np.stack([left, down - left], axis=1)
    part = np.bincount(index.ravel(), sides.ravel(), height * LINES * (width + 2))
    part = part.astype(float, copy=False).reshape(height * LINES, width + 2)  # int64 if empty
    np.abs(np.cumsum(part, axis=1, out=part), out=part)
    np.rint(np.multiply(part, UNIT, out=part), out=part)
    rows = part.reshape(height, LINES, width + 2).sum(axis=1)
    return box, rows[:, :width].astype(np.int32) // LINES


def _crossings(corners: Floats, y: Floats) -> tuple[NDArray[np.int64], Floats, NDArray[np.int64]]:
    """Return where lines at y (L,) cross the sides of a polygon (P, 2), ordered by side.

    :return: index of the line, u of the crossing [px], and 1 if the side goes down, -1 if up, (C,)
        each.
    """
    (x0, y0), (x1, y1) = corners.T, np.roll(corners, -1, axis=0).T
    top, bottom = np.searchsorted(y, [np.minimum(y0, y1), np.maximum(y0, y1)])
    count = bottom - top
    side = np.repeat(np.arange(len(corners)), count)
    line = np.arange(len(side)) + (top - (np.cumsum(count) - count))[side]
    slope = np.divide(x1 - x0, y1 - y0, out=np.zeros(len(corners)), where=count > 0)
    return line, x0[side] + (y[line] - y0[side]) * slope[side], np.where(y1 > y0, 1, -1)[side]
