"""Contours of nothing: the foreground does not fill them, or is a place that something has left."""

import cv2
import numpy as np

from colortrack_ros.contours.areas import Mask
from colortrack_ros.contours.background import CROSS
from colortrack_ros.contours.background import edges_at
from colortrack_ros.contours.background import softened
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.detection.background_model import Picture

LEAST_FILLED = 0.1
"""Least share of its outline that is foreground: regions.LEAST_OVERLAP, with which a target takes
part of somebody else's area for its own. Of ten clips 78 false rows of 610 have less and 6 of 2,587
right ones, 59 and 1 with half, 122 and 30 with twice the value (benchmark/notes/contours.md)."""

LEFT_EDGES = 2.0
"""Ratio of the edges around a foreground, in the background over those in the picture, from which
it is a place that something has left. Of the same clips 46 false rows and no right one have more;
with 1.5 of it 78 and 23, with 3 of it 15 and 0."""

MARGIN_PIXELS = 2
"""Foreground this near to an outline belongs to it [px]: the rim that the Gaussian adds
(foreground.RIM_SHARE)."""

MARGIN_SQUARE = np.ones((2 * MARGIN_PIXELS + 1, 2 * MARGIN_PIXELS + 1), np.uint8)
"""That around a pixel."""


def is_vacant(outlines: Floats, mask: Mask, picture: Picture, background: Picture) -> Bools:
    """Return which outlines, (N, P, 2) [px], are of nothing, (N,).

    A thing has edges around it in the picture, a place that one has left in the background.

    :param mask: (H, W), not 0 where the picture differs from the background.
    :param picture: (H, W, channels).
    :param background: of the same shape.
    """
    return np.array([_shows_nothing(each, mask, picture, background) for each in outlines], bool)


def _shows_nothing(outline: Floats, mask: Mask, picture: Picture, background: Picture) -> bool:
    low = np.maximum(_whole(outline.min(axis=0)) - MARGIN_PIXELS - 1, 0)
    right, bottom = np.maximum(_whole(outline.max(axis=0)) + MARGIN_PIXELS + 2, 0).tolist()
    part = np.s_[low[1] : bottom, low[0] : right]
    differs = np.minimum(mask[part], 1)
    if not differs.any():
        return True
    inside = np.zeros_like(differs)
    cv2.fillPoly(inside, [_whole(outline) - low], 1)
    if cv2.countNonZero(cv2.bitwise_and(differs, inside)) < LEAST_FILLED * cv2.countNonZero(inside):
        return True
    own = differs & cv2.dilate(inside, MARGIN_SQUARE)
    rim: Bools = own > cv2.erode(own, CROSS)
    now, before = (edges_at(softened(each[part]), rim).sum() for each in (picture, background))
    return bool(before > LEFT_EDGES * now)


def _whole(points: Floats) -> Indices:
    return np.rint(points).astype(np.int32)
