"""Splits the blobs of touching objects."""

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.blobs import positions
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.shape import circularity

DISC_CIRCULARITY = 0.95
"""Circularity above which a blob is a single disc: two equal discs that touch have 2/3, rendered
balls have at least 0.995."""

CUT_LEVELS = np.arange(0.95, 0.25, -0.05)
"""Levels that cut the distance transform, as shares of its maximum. Steps of half and of twice the
size change the centroids of `swarm` and `collision` by less than 0.0001 px."""

PROMINENCE = 1.25
"""Least ratio of a part's largest distance from the outline to that of the neck. Chosen. In `python
benchmark/detection_quality.py --constants` centroids of a crowd are off by 0.40 px with half of it,
which cuts at any neck, 0.81 with it, and 1.35 with twice."""

MOST_TOUCHING = 8
"""Maximum number of touching objects, as a multiple of max_area: larger blobs are something else,
and their distance transform is slow."""


def split_touching(image: LabelImage, blobs: BlobTable, max_area: float = np.inf) -> bool:
    """Split blobs at their necks, in place, with a line of label 0.

    If two discs touch, the distance to the outline has two peaks and a lower neck between them. A
    blob is split if, at some level, it falls apart into parts that all rise above the level by
    PROMINENCE. Each pixel goes to the nearest part.

    :param max_area: of an object [px].
    :returns: whether anything was split.
    """
    changed = False
    for k in np.flatnonzero(
        (circularity(blobs) < DISC_CIRCULARITY) & (blobs.area <= MOST_TOUCHING * max_area)
    ):
        left, top, width, height = blobs.box[k]
        runs = blobs.take(np.arange(len(blobs.area)) == k).runs
        v, u = np.divmod(positions(runs), runs.stride)
        # Add a margin of pixels outside the blob.
        mask = np.zeros((height + 2, width + 2), np.uint8)
        mask[v - top + 1, u - left + 1] = 1
        parts = cores(distance_of(mask))
        if parts is None:
            continue
        line = _watershed(parts)[v - top + 1, u - left + 1]
        image.pixels[v[line], u[line]] = 0
        changed = True
    return changed


def distance_of(mask: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(H, W) distance of each pixel of a mask from what is outside [px].

    The squares are integers. OpenCV 5 rounds the distances by where in memory they lie, and equal
    ones must stay equal.
    """
    distance = cv2.distanceTransform(mask, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.sqrt(np.rint(distance * distance))


def cores(
    distance: NDArray[np.float32],
    prominence: float = PROMINENCE,
) -> NDArray[np.bool_] | None:
    """The cores of the parts of a blob, or None if it has only one.

    :param distance: of each pixel from what is outside the blob [px].
    :param prominence: least ratio of a part's largest distance to that of its neck.
    """
    best, most, order = None, 1, None
    for level in CUT_LEVELS * float(distance.max()):
        count, part = cv2.connectedComponents((distance > level).view(np.uint8))
        if count <= most + 1:
            continue
        if order is None:
            order = distance.argsort(axis=None)
            ascending = distance.reshape(-1)[order]
        peak = np.zeros(count)
        peak[part.reshape(-1)[order]] = ascending  # the last of each part, its largest, stays
        prominent = (peak >= prominence * level) & (np.arange(count) > 0)
        if prominent.sum() > most:
            best, most = prominent[part], int(prominent.sum())
    return best


def _watershed(parts: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels at which the nearest core changes to the right or in the row below."""
    _, nearest = cv2.distanceTransformWithLabels(
        (~parts).view(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_CCOMP
    )
    line = np.zeros(parts.shape, bool)
    line[:, :-1] = nearest[:, :-1] != nearest[:, 1:]
    line[:-1] |= nearest[:-1] != nearest[1:]
    line[:-1, :-1] |= nearest[:-1, :-1] != nearest[1:, 1:]
    line[:-1, 1:] |= nearest[:-1, 1:] != nearest[1:, :-1]
    return line
