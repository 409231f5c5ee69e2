"""Which boxes can be followed."""

import numpy as np

from colortrack_ros.data import Frame
from colortrack_ros.windows.config import WindowConfig
from colortrack_ros.windows.crop import cut_window
from colortrack_ros.windows.motion import Bools
from colortrack_ros.windows.motion import Floats

LEAST_SIDE = 5
"""Pixels that a template is wide and high, at least: 25 for the six unknowns of Template.align."""

UNIFORM_LEVELS = 0.5
"""Standard deviation of a uniform patch, at most [levels]: what rounding leaves of no texture."""


def centers(boxes: Floats) -> Floats:
    """Centers (N, 2) of boxes, (N, 4) [px]."""
    return boxes[:, :2] + (boxes[:, 2:] - 1) / 2


def are_followable(frame: Frame, boxes: Floats, config: WindowConfig) -> Bools:
    """Which boxes can be told from what is around them, (N,).

    Their centers are in the picture, and they are no larger than it. They fill at least half of the
    least template, unless its size is given: else it would show what is beside the target. And the
    picture has some texture as far as the target is searched for.

    :param boxes: (N, 4) u, v of the top left pixel, width and height [px].
    """
    center, side = centers(boxes), boxes[:, 2:]
    size = np.array(frame.image.shape[1::-1])
    with np.errstate(invalid='ignore'):
        inside = (center >= 0) & (center <= size - 1) & (side >= 1) & (side <= size)
        least = 1 if config.window else LEAST_SIDE**2 / 2
        good = np.asarray(inside.all(axis=1) & (side.prod(axis=1) >= least))
    reach = np.array([config.search_width, config.search_height])
    for i in np.flatnonzero(good):
        around = np.minimum(side[i] + reach, size)[::-1].astype(int)
        good[i] = cut_window(frame, center[i], tuple(around.tolist())).std() > UNIFORM_LEVELS
    return good
