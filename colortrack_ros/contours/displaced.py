"""Areas where the background moves slightly, such as leaves in the wind or fluttering tape."""

import numpy as np

from colortrack_ros.contours.areas import Areas
from colortrack_ros.data import Bools
from colortrack_ros.data import Indices
from colortrack_ros.detection.background_model import Picture

MOVE_REACH = 2
"""Largest displacement of the background [px]. IDF1, precision of KITTI-17, as is and mirrored,
and of TUD Campus are 0.15, 0.28; 0.23, 0.39; 0.40, 0.76, with half 0.19, 0.33; 0.16, 0.29; 0.41,
0.78, with twice the value 0.13, 0.28; 0.19, 0.47; 0.45, 0.91 (``benchmark/real_contours.py FOLDER
--constants displaced.MOVE_REACH``)."""

DISPLACED_SHARE = 0.5
"""Least share of an area that is displaced background: most of it. IDF1 and precision of KITTI-17
mirrored are 0.19, 0.50 and 0.18, 0.28, not 0.23, 0.39, with half and twice the value, of TUD Campus
0.47, 0.89 and 0.39, 0.71, not 0.40, 0.76 (as above); with 0.3 others lose
(benchmark/notes/contours.md)."""

AREA_PIXELS = 64
"""Pixels of an area that are sampled: the standard deviation of a share of one half is 1/16."""


def is_displaced(areas: Areas, picture: Picture, background: Picture, threshold: float) -> Bools:
    """Return which areas, (K,), show background from nearby (Elgammal et al. 2000).

    Only pixels that differ from the background at their own place count; the rim that the Gaussian
    adds does not.

    :param picture: (H, W, channels).
    :param background: of the same shape.
    :param threshold: largest difference of equal pixels, mean of the channels [levels].
    """
    if not len(areas):
        return np.zeros(0, bool)
    pixels = [pixels_of(areas, k) for k in range(len(areas))]
    owner = np.repeat(np.arange(len(areas)), [len(p) for p in pixels])
    v, u = np.concatenate(pixels).T
    steps = np.arange(-MOVE_REACH, MOVE_REACH + 1)
    rows = np.clip(v[:, None, None] + steps[:, None], 0, background.shape[0] - 1)
    columns = np.clip(u[:, None, None] + steps, 0, background.shape[1] - 1)
    near = background[rows, columns].astype(np.int16)
    off = np.abs(near - picture[v, u, None, None]).mean(axis=3)
    differs = off[:, MOVE_REACH, MOVE_REACH] > threshold
    close = differs & (off.min(axis=(1, 2)) <= threshold)
    count, alike = (np.bincount(owner, each, len(areas)) for each in (differs, close))
    return np.asarray(alike > DISPLACED_SHARE * count)


def pixels_of(areas: Areas, k: int) -> Indices:
    """Return rows and columns, (P, 2), of at most AREA_PIXELS pixels of an area."""
    mask = areas.mask[k]
    own = np.flatnonzero(mask)
    own = own[np.linspace(0, len(own) - 1, min(len(own), AREA_PIXELS)).astype(int)]
    return np.stack(np.divmod(own, mask.shape[1]), axis=1) + areas.box[k, [1, 0]].astype(int)
