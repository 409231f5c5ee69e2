"""How much targets change their form, and how well their middles are known then.

A rigid thing keeps its aspect ratio when it comes nearer. Somebody who walks does not, nor does a
contour that leaves out legs now and takes in shadows then, for longer than filters average.
"""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.estimation.records import Records

FORM_SECONDS = 1.0
"""Time constant of the mean form [s]: two steps of somebody who walks. Assumed."""


def form(size: Floats) -> Floats:
    """Return the logarithms of the aspect ratios, (N,), of widths and heights, (N, 2)."""
    return np.asarray(np.log(size[:, 0] / size[:, 1]))


def learn_form(records: Records, size: Floats, seconds: float, now: int) -> None:
    """Learn the mean form of targets that were measured, and its mean squared deviation.

    :param records: (N,) with `form` and `deformed`, which are updated.
    :param size: (N, 2) width and height of the outlines [px].
    :param seconds: since the last frame.
    :param now: stamp [ns].
    """
    share = np.maximum(seconds / FORM_SECONDS, 1 / np.maximum(records['hits'], 1))
    share = np.where(records['updated'] == now, np.minimum(share, 1.0), 0.0)
    anew = (records['placed'] == now) & ~records['by_area']
    records['form'][anew] = form(size[anew])  # it was less exact, so that this is no deformation
    step = form(size) - records['form']
    records['form'] += share * step
    records['deformed'] += share * (step**2 - records['deformed'])


def deformation_variance(records: Records, size: Floats) -> Floats:
    """Return the variances of the middles on each axis, (N, 1) [px^2].

    Where one side moves by a share of the length, the middle moves by half of that. Which side it
    was an aspect ratio does not tell, so the longer one counts.
    """
    return np.asarray(records['deformed'][:, None] / 4 * size.max(axis=1, keepdims=True) ** 2)
