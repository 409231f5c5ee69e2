"""Where a thing shows its own color, from a pixel of its highlight."""

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.growth import NEAR
from colortrack_ros.detection.growth import OFF_LINE
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.lab import Triple

CLIMB_STEP = 2
"""Longest step [px]. Colors of video are constant over 2 by 2 pixels, and so is their slope."""

LEAST_RISE = 0.1
"""Least gain of a step [CIELAB units], so that a climb ends: less than a level of eight bits, and
far more than rounding."""


def own_color_at(rgb: NDArray[np.uint8], u: int, v: int, color: Triple) -> tuple[int, int]:
    """The pixel u, v that a climb to more and more saturated colors of one hue ends at.

    The light that a surface reflects like a mirror is added to that of its own color (Shafer 1985),
    and what is too light for the camera loses its color. Both lead from its own color to white.

    :param rgb: (H, W, 3).
    :param u, v: where the climb begins [px].
    :param color: CIELAB of what is there; gray has no hue, and the climb ends where it begins.
    """
    chroma = np.hypot(*color[1:])
    if chroma < NEAR:
        return u, v
    along, across = np.array([color[1:], (-color[2], color[1])]) / chroma
    smooth = np.asarray(cv2.blur(rgb, (3, 3)), np.uint8)
    while True:
        left, top = max(u - CLIMB_STEP, 0), max(v - CLIMB_STEP, 0)
        window = smooth[top : v + CLIMB_STEP + 1, left : u + CLIMB_STEP + 1]
        plane = lab_from_rgb(window)[..., 1:]
        saturation = plane @ along
        saturation[abs(plane @ across) > OFF_LINE * saturation] = 0
        row, column = divmod(int(saturation.argmax()), saturation.shape[1])
        if saturation[row, column] < saturation[v - top, u - left] + LEAST_RISE:
            return u, v
        u, v = left + column, top + row
