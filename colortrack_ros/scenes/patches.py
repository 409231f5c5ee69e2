"""Textured squares that rotate and change their size.

Like everything in a scene, their pictures are bit-identical on every machine.
"""

from dataclasses import dataclass
from dataclasses import field

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.scenes.curves import constant
from colortrack_ros.scenes.curves import Curve
from colortrack_ros.scenes.shapes import Ball
from colortrack_ros.scenes.texture import Color
from colortrack_ros.scenes.texture import value_noise

TEXTURE_SIDE = 64
"""Rows and columns of a texture: about a pixel each of the patches at 1280x720."""

TEXTURE_CONTRAST = 0.7
"""Amplitude of a texture over the mean of its color; chosen for the look of printed cloth."""


@dataclass(frozen=True)
class Patch(Ball):
    """A textured square; its radius is half its side.

    :param texture: (TEXTURE_SIDE, TEXTURE_SIDE, 3) BGR.
    :param turn: tangent of half its angle of rotation to the right, over time.
    """

    texture: NDArray[np.float64] = field(
        default_factory=lambda: np.zeros((TEXTURE_SIDE, TEXTURE_SIDE, 3))
    )
    turn: Curve = field(default_factory=lambda: constant(0.0))


def relief(seed: tuple[int, ...]) -> NDArray[np.float64]:
    """Return (TEXTURE_SIDE, TEXTURE_SIDE), bumps of two sizes in [-1, 1]."""
    coarse = value_noise((*seed, 0), TEXTURE_SIDE, TEXTURE_SIDE, TEXTURE_SIDE / 5)
    return 0.6 * coarse + 0.4 * value_noise(
        (*seed, 1), TEXTURE_SIDE, TEXTURE_SIDE, TEXTURE_SIDE / 11
    )


def texture(bumps: NDArray[np.float64], color: Color) -> NDArray[np.float64]:
    """Return the texture (S, S, 3) BGR of bumps (S, S) on a color; S is TEXTURE_SIDE."""
    shade = 1 + TEXTURE_CONTRAST * bumps[..., None]
    return np.clip(shade * np.array(color[::-1], float), 0, 255)


def draw_patch(
    image: NDArray[np.uint8], center: NDArray[np.float64], half: float, turn: float, patch: Patch
) -> None:
    """Draw a patch, anti-aliased, in place, without motion blur.

    :param image: (H, W, 3) BGR.
    :param center: (2,) u, v [px].
    :param half: half its side [px].
    :param turn: tangent of half the angle.
    """
    box, x, y = _turned(image, center, half, turn)
    if x.size == 0:
        return
    cover = np.clip(half + 0.5 - np.abs(x), 0, 1) * np.clip(half + 0.5 - np.abs(y), 0, 1)
    color = _sample(patch.texture, x / half, y / half)
    mixed = image[box] + cover[..., None] * (color - image[box])
    image[box] = np.rint(mixed).astype(np.uint8)


def paint_patch(
    mask: NDArray[np.uint8], center: NDArray[np.float64], half: float, turn: float, value: int
) -> None:
    """Set the pixels of the mask (H, W) whose centers are in the patch."""
    box, x, y = _turned(mask, center, half, turn)
    mask[box][(np.abs(x) <= half) & (np.abs(y) <= half)] = value


def _turned(
    image: NDArray, center: NDArray, half: float, turn: float
) -> tuple[tuple[slice, slice], NDArray[np.float64], NDArray[np.float64]]:
    """Return the pixels that a patch may touch and their x and y along its sides [px]."""
    reach, size = 1.5 * half + 1, np.array(image.shape[1::-1])
    first = np.clip(np.ceil(center - reach), 0, size).astype(int)
    last = np.clip(np.floor(center + reach) + 1, 0, size).astype(int)
    cosine, sine = (1 - turn * turn) / (1 + turn * turn), 2 * turn / (1 + turn * turn)
    u = np.arange(first[0], last[0]) - center[0]
    v = (np.arange(first[1], last[1]) - center[1])[:, None]
    box = slice(first[1], last[1]), slice(first[0], last[0])
    return box, cosine * u + sine * v, cosine * v - sine * u


def _sample(picture: NDArray, x: NDArray, y: NDArray) -> NDArray[np.float64]:
    """Return the texture at x, y in [-1, 1], interpolated bilinearly."""
    column, row = (
        np.clip((p + 1) * ((TEXTURE_SIDE - 1) / 2), 0, TEXTURE_SIDE - 1.001) for p in (x, y)
    )
    i, j = row.astype(int), column.astype(int)
    down, right = (row - i)[..., None], (column - j)[..., None]
    upper = picture[i, j] + right * (picture[i, j + 1] - picture[i, j])
    lower = picture[i + 1, j] + right * (picture[i + 1, j + 1] - picture[i + 1, j])
    return upper + down * (lower - upper)
