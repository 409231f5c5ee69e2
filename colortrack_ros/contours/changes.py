"""Whether the picture has changed where a target began: what moves on leaves its place."""

import numpy as np

from colortrack_ros.contours.areas import Areas
from colortrack_ros.contours.background import STILL_LEVELS
from colortrack_ros.contours.displaced import AREA_PIXELS
from colortrack_ros.contours.displaced import pixels_of
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.detection.background_model import Picture
from colortrack_ros.estimation.records import Records

CHANGED_SHARE = 0.1
"""Least share of the first pixels that change when a target moves on: by min_motion it has left
more than a fifth of them. On six clips less than this changes within 2 s at 221 false contours, and
at none of 3,600 true ones (benchmark/notes/contours.md)."""


def remember(records: Records, areas: Areas, picture: Picture) -> None:
    """Record what the picture shows where targets begin.

    :param records: (K,) of the new targets, with CONTOUR_FIELDS.
    :param areas: K areas that they begin on.
    :param picture: (H, W, channels).
    """
    for k in range(len(areas)):
        pixels = pixels_of(areas, k)
        records['first_at'][k] = np.resize(pixels, (AREA_PIXELS, 2))
    records['first_level'] = _levels(picture, records['first_at'])


def has_changed(records: Records, picture: Picture) -> Bools:
    """Return which targets, (N,), have left a part of the place where they began.

    What the background shows of something that has gone differs from the picture, but stands still,
    whatever its contour does. Told targets need not move.

    :param records: (N,) with CONTOUR_FIELDS.
    :param picture: (H, W, channels).
    """
    if not picture.size:
        return np.asarray(records['told'])
    last = np.array(picture.shape[:2]) - 1  # pictures may have become smaller
    now = _levels(picture, np.minimum(records['first_at'], last))
    share = (np.abs(now - records['first_level']) > STILL_LEVELS).mean(axis=1)
    return np.asarray((share >= CHANGED_SHARE) | records['told'])


def _levels(picture: Picture, pixels: Indices) -> Floats:
    """Return the means of the channels, (N, P), of pixels, (N, P, 2) rows and columns."""
    return np.asarray(picture[pixels[..., 0], pixels[..., 1]].mean(axis=-1))
