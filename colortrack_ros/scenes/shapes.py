"""The things in a scene, and how they are drawn.

Pictures are bit-identical on every machine: only single-precision + - * / and square root are used,
which IEEE 754 defines exactly, and sums are of integers.
"""

from dataclasses import dataclass
from dataclasses import field
import math

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

from colortrack_ros.scenes.curves import constant
from colortrack_ros.scenes.curves import Curve
from colortrack_ros.scenes.texture import Color

UNIT = 1024
"""The fixed-point 1 of coverage and brightness: its product with a byte fits 32 bits easily."""

AMBIENT, DIFFUSE, HIGHLIGHT = 0.80, 0.32, 34.0
"""Brightness of a ball: (AMBIENT + DIFFUSE * Lambert's cosine) * color + HIGHLIGHT * gloss. Chosen
to look like a matte ball in a bright room: its darkest side keeps 80 % of the color."""

LIGHT = (-2 / 7, -3 / 7, 6 / 7)
"""Unit vector to the light: right, down, toward the camera."""

HALFWAY = (-2 / math.sqrt(182), -3 / math.sqrt(182), 13 / math.sqrt(182))
"""Unit vector halfway between light and camera: where a ball is glossiest (Blinn 1977)."""

Box = tuple[slice, slice]


@dataclass(frozen=True)
class Ball:
    """A shaded ball.

    :param path: u, v and radius [px] over time.
    :param color: a name of the scene's colors.
    :param gain: factor on its brightness over time, 0..1.1.
    """

    path: Curve
    color: str
    gain: Curve = field(default_factory=lambda: constant(1.0))


@dataclass(frozen=True)
class Prop:
    """A moving thing that is not to be tracked: an upright rectangle, or a shaded ball.

    :param path: u, v, and half the width and half the height [px] (for a ball: its radius, twice).
    :param color: R, G, B.
    :param round: whether it is a ball.
    """

    path: Curve
    color: Color
    round: bool = False


@dataclass(frozen=True)
class Cover:
    """A rectangle that stands still in front of everything.

    :param row, column: of its top left pixel.
    :param picture: (h, w, 3) BGR.
    """

    row: int
    column: int
    picture: NDArray[np.uint8]


def draw_ball(
    image: NDArray[np.uint8],
    center: NDArray[np.float64],
    smear: NDArray[np.float64],
    radius: float,
    color: ArrayLike,
) -> None:
    """Draw a shaded ball, anti-aliased, with motion blur, in place.

    :param image: (H, W, 3) BGR.
    :param center: (2,) u, v in the middle of the exposure [px].
    :param smear: (2,) motion during the exposure [px].
    :param radius: [px].
    :param color: (3,) BGR, brightness included.
    """
    box = _box(image, center, smear, radius, radius)
    x, y = _offsets(box, center, smear)
    if x.size == 0 or y.size == 0:
        return
    squared = x * x + y * y
    coverage = np.clip(np.float32(radius + 0.5) - np.sqrt(squared), 0, 1)
    z = np.sqrt(np.maximum(np.float32(radius * radius) - squared, 0))
    cosine = _cosine(x, y, z, LIGHT, radius)
    gloss = _cosine(x, y, z, HALFWAY, radius)
    for _ in range(4):
        gloss *= gloss  # to the 16th power
    bright = coverage * (cosine * np.float32(DIFFUSE) + np.float32(AMBIENT))
    total = len(x) * UNIT
    _blend(
        image[box],
        total - _sum(coverage),
        _sum(bright)[..., None] * np.rint(color).astype(np.int32)
        + _sum(coverage * gloss)[..., None] * np.int32(HIGHLIGHT),
        total,
    )


def draw_rectangle(
    image: NDArray[np.uint8],
    center: NDArray[np.float64],
    smear: NDArray[np.float64],
    half: NDArray[np.float64],
    color: ArrayLike,
) -> None:
    """Draw a plain rectangle, anti-aliased, with motion blur, in place.

    :param half: (2,) half the width, half the height [px]; the others as of :func:`draw_ball`.
    """
    box = _box(image, center, smear, *half)
    x, y = _offsets(box, center, smear)
    if x.size == 0 or y.size == 0:
        return
    across = np.clip(np.float32(half[0] + 0.5) - np.abs(x), 0, 1)
    down = np.clip(np.float32(half[1] + 0.5) - np.abs(y), 0, 1)
    covered, total = _sum(across * down), len(x) * UNIT
    _blend(
        image[box],
        total - covered,
        covered[..., None] * np.rint(color).astype(np.int32),
        total,
    )


def paint_disc(
    mask: NDArray[np.uint8], center: NDArray[np.float64], radius: float, value: int
) -> None:
    """Set the pixels of the mask (H, W) whose centers are in the disc."""
    box = _box(mask, center, np.zeros(2), radius, radius)
    x, y = (np.arange(s.start, s.stop) - c for s, c in zip(box[::-1], center, strict=True))
    mask[box][x * x + (y * y)[:, None] <= radius * radius] = value


def paint_rectangle(
    mask: NDArray[np.uint8], center: NDArray[np.float64], half: NDArray[np.float64], value: int
) -> None:
    """Set the pixels of the mask (H, W) whose centers are in the rectangle."""
    u, v = (
        slice(*np.maximum(np.ceil([c - h, c + h]), 0).astype(int))
        for c, h in zip(center, half, strict=True)
    )
    mask[v, u] = value


def _box(
    image: NDArray, center: NDArray, smear: NDArray, half_width: float, half_height: float
) -> Box:
    """Return the rows and columns that a blurred thing may touch."""
    half_width, half_height = half_width + 1 + abs(smear[0]), half_height + 1 + abs(smear[1])
    height, width = image.shape[:2]
    (u, v), clipped = center.tolist(), lambda x, most: int(min(max(x, 0), most))
    rows = slice(clipped(v - half_height, height), clipped(v + half_height + 1, height))
    return rows, slice(clipped(u - half_width, width), clipped(u + half_width + 1, width))


def _offsets(box: Box, center: NDArray, smear: NDArray) -> tuple[NDArray, NDArray]:
    """Return x (s, 1, w) and y (s, h, 1) of the box's pixels from the center [px].

    The exposure is divided into s moments, so that the thing moves at most a pixel between two.
    """
    count = int(np.sqrt(smear[0] * smear[0] + smear[1] * smear[1])) + 1
    moments = (np.arange(1 - count, count, 2) / (2 * count))[:, None]
    rows, columns = box
    x = np.arange(columns.start, columns.stop) - (center[0] + smear[0] * moments)
    y = np.arange(rows.start, rows.stop) - (center[1] + smear[1] * moments)
    return x.astype(np.float32)[:, None, :], y.astype(np.float32)[:, :, None]


def _cosine(
    x: NDArray, y: NDArray, z: NDArray, direction: tuple[float, float, float], radius: float
) -> NDArray[np.float32]:
    """Return the cosine between the surface normal (x, y, z) / radius and the direction, >= 0."""
    right, down, front = (np.float32(d / radius) for d in direction)
    return np.maximum(x * right + y * down + z * front, 0)


def _sum(values: NDArray[np.float32]) -> NDArray[np.int32]:
    """Return the sum over the moments of the exposure, in fixed-point numbers."""
    return (values * np.float32(UNIT)).astype(np.int32).sum(axis=0, dtype=np.int32)


def _blend(patch: NDArray[np.uint8], through: NDArray, added: NDArray, total: int) -> None:
    """Let `through / total` of the patch shine through and add `added / total`, in place."""
    mixed = (patch * through[..., None] + added + total // 2) // total
    patch[:] = np.minimum(mixed, 255)
