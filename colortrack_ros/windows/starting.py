"""Boxes that can be followed."""

import cv2
import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.windows.config import LEAST_SIDE
from colortrack_ros.windows.config import WindowConfig
from colortrack_ros.windows.crop import cut_window
from colortrack_ros.windows.crop import Gray

UNIFORM_LEVELS, NOISE_PIXELS = 1.0, 4
"""Largest standard deviation of a uniform patch [levels], in means of that many pixels along either
axis, beside light that falls off to one side. Five of six walls of real films have 0.4 to 0.7, the
surroundings of 127 targets at least 10 (benchmark/notes/windows.md)."""


def centers(boxes: Floats) -> Floats:
    """Return the centers, (N, 2), of boxes, (N, 4) [px]."""
    return boxes[:, :2] + (boxes[:, 2:] - 1) / 2


def are_centered_in(boxes: Floats, position: Floats, size: Floats) -> Bools:
    """Return which boxes, (N,), have their center inside one of others.

    :param boxes: (N, 4) [px].
    :param position: (M, 2) centers of the others [px].
    :param size: (M, 2) their width and height [px].
    """
    inside = np.all(np.abs(centers(boxes)[:, None] - position) <= size / 2, axis=2)
    return np.asarray(np.any(inside, axis=1))


def are_followable(frame: Frame, boxes: Floats, config: WindowConfig) -> Bools:
    """Return which boxes, (N,), can be told from their surroundings.

    The center must lie inside the picture, and the box may not be larger than the picture, which
    has to hold a template. Unless the size of the template is given, the box must fill at least
    half of the smallest one, which would otherwise show mostly background. And the search region
    must show more than a wall does.

    :param boxes: (N, 4) u, v of the top left pixel, width and height [px].
    """
    center, side = centers(boxes), boxes[:, 2:]
    size = np.array(frame.image.shape[1::-1])
    with np.errstate(invalid='ignore', over='ignore'):
        inside = (center >= 0) & (center <= size - 1) & (side >= 1) & (side <= size)
        least = 1 if config.window else LEAST_SIDE**2 / 2
        good = inside.all(axis=1) & (side.prod(axis=1) >= least) & (size >= LEAST_SIDE).all()
    reach = np.array([config.search_width, config.search_height])
    for i in np.flatnonzero(good):
        around = np.minimum(side[i] + reach, size)[::-1].astype(int)
        good[i] = not _is_uniform(cut_window(frame, center[i], tuple(around.tolist())))
    return good


def _is_uniform(window: Gray) -> bool:
    """Return whether a window, (h, w), shows at most noise, and light from one side."""
    size = tuple(max(side // NOISE_PIXELS, 1) for side in window.shape[::-1])
    gray = np.asarray(cv2.resize(window, size, interpolation=cv2.INTER_AREA))
    ramp = np.stack(
        [*(axis.ravel() for axis in np.indices(gray.shape)), np.ones(gray.size)], axis=1
    )
    light = ramp @ np.linalg.lstsq(ramp, gray.ravel(), rcond=None)[0]
    return bool((gray.ravel() - light).std() <= UNIFORM_LEVELS)
