"""Things of any outline: polygons that turn and change their size.

As of everything in a scene, their pictures are the same to the bit on every machine.
"""

from dataclasses import dataclass
from dataclasses import field

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

from colortrack_ros.scenes.curves import constant
from colortrack_ros.scenes.curves import Curve
from colortrack_ros.scenes.shapes import Ball
from colortrack_ros.scenes.shapes import UNIT
from colortrack_ros.scenes.texture import Color

Floats = NDArray[np.float64]

LINES = 16
"""Lines in each row of pixels along which the covered part is exact: coverage is right to 1/16."""

ARC = 24
"""Points on an arc: half a circle of 100 px radius is off by 0.23 px at most."""

PI = 3.141592653589793
"""Written out: a scene is the same to the bit on every machine."""


@dataclass(frozen=True)
class Silhouette(Ball):
    """A plain polygon. Its radius is that of the disc of the same area, u and v are its centroid.

    :param outline: (P, 2) corners, of area pi around the centroid (0, 0); see :func:`normalized`.
    :param turn: tangent of half the angle by which it is turned to the right, over time.
    :param marks: polygons on it and their colors, in the same units.
    """

    outline: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    turn: Curve = field(default_factory=lambda: constant(0.0))
    marks: tuple[tuple[Floats, Color], ...] = ()


def normalized(points: ArrayLike) -> tuple[Floats, Floats, float]:
    """Return a polygon (P, 2) moved and scaled to area pi around (0, 0), and from where.

    :return: the polygon, its centroid (2,) and what it was divided by.
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
    """Return ARC points on a circle, around it to the right.

    :param towards: the direction, of length 1, that the middle of the arc lies in.
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
    """Draw a simple polygon, anti-aliased, in place, as if the shutter took no time.

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
    """Return the pixels that a polygon may touch, and the covered part of each in UNIT.

    A side that goes down covers what is to its right, one that goes up takes it away: exact along
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
    # side by side, and in place, since these are megabytes: sums are the same to the bit
    index = (line * (width + 2) + pixel)[:, None] + [0, 1]
    sides = np.stack([left, down - left], axis=1)
    part = np.bincount(index.ravel(), sides.ravel(), height * LINES * (width + 2))
    part = part.astype(float, copy=False).reshape(height * LINES, width + 2)  # int64 if empty
    np.abs(np.cumsum(part, axis=1, out=part), out=part)
    np.rint(np.multiply(part, UNIT, out=part), out=part)
    rows = part.reshape(height, LINES, width + 2).sum(axis=1)
    return box, rows[:, :width].astype(np.int32) // LINES


def _crossings(corners: Floats, y: Floats) -> tuple[NDArray[np.int64], Floats, NDArray[np.int64]]:
    """Return where lines at y (L,) cross the sides of a polygon (P, 2), side by side.

    :return: which line, its u there [px], and 1 where the side goes down, -1 where up, (C,) each.
    """
    (x0, y0), (x1, y1) = corners.T, np.roll(corners, -1, axis=0).T
    top, bottom = np.searchsorted(y, [np.minimum(y0, y1), np.maximum(y0, y1)])
    count = bottom - top
    side = np.repeat(np.arange(len(corners)), count)
    line = np.arange(len(side)) + (top - (np.cumsum(count) - count))[side]
    slope = np.divide(x1 - x0, y1 - y0, out=np.zeros(len(corners)), where=count > 0)
    return line, x0[side] + (y[line] - y0[side]) * slope[side], np.where(y1 > y0, 1, -1)[side]
