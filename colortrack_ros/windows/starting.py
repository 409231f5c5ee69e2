"""Boxes that can be followed."""

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.windows.config import LEAST_SIDE
from colortrack_ros.windows.config import WindowConfig
from colortrack_ros.windows.crop import cut_window

UNIFORM_LEVELS = 0.5
"""Largest standard deviation of a uniform patch [levels]: rounding alone makes as much."""


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
    must have some texture.

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
        good[i] = cut_window(frame, center[i], tuple(around.tolist())).std() > UNIFORM_LEVELS
    return good
