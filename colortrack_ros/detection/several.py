"""Blobs of several discs, none of which was seen alone: each of them is somewhere inside."""

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.shape import circularity
from colortrack_ros.detection.shape import PIXEL_MOMENT
from colortrack_ros.detection.split import cores
from colortrack_ros.detection.split import DISC_CIRCULARITY
from colortrack_ros.detection.split import distance_of
from colortrack_ros.detection.templates import mask_of

MOST_FILLED = 0.985
"""Area over that of the ellipse with the same second moments, below which a blob may be several
discs: two that touch have 0.90, a rectangle and half a disc 0.955. It saves time."""

MOST_CONVEX = 0.985
"""Share of the pixels in its convex hull below which a blob may have a neck: of overlapping discs
of 3 to 15 px that have one 0 to 20 % are above, of rods at any angle all. It saves time."""

SHALLOW_NECK = 1.07
"""Least ratio of a part's radius to its neck for it to be counted: less than split asks for, since
nothing is cut here."""

LEAST_COVERED = 0.7
"""Least share of a blob that its inscribed discs cover: things with arms and necks have less."""

MOST_LOOKED_AT, BOARD = 8, 3000
"""Limits that bound the time: blobs in a picture, and the size of the picture of each [px]."""


def places_inside(blobs: BlobTable, inside: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Covariance of where the discs in each blob are, about the centroid; 0 for a single thing.

    A detection is of one object, and which of them is open: two discs are one radius off along the
    line between their centers, and not at all across it.

    :param inside: (N,) which blobs are clear of the border of the picture; others are not judged.
    :returns: (N, 2, 2) [px^2].
    """
    covariance = np.zeros((len(blobs.area), 2, 2))
    may_be = (circularity(blobs) < DISC_CIRCULARITY) & (filled(blobs) < MOST_FILLED)
    may_be &= inside
    may_be &= may_be.cumsum() <= MOST_LOOKED_AT
    if may_be.any():
        may_be[may_be] = convexity(blobs.take(may_be)) < MOST_CONVEX
    for k in may_be.nonzero()[0].tolist():
        mask = mask_of(blobs, k)
        step = int(np.ceil(np.sqrt(mask.size / BOARD)))
        center = step * _centers(_whole(mask[::step, ::step])) + blobs.box[k, :2] - blobs.mean[k]
        covariance[k] = center.T @ center / max(len(center), 1)
    return covariance


def filled(blobs: BlobTable) -> NDArray[np.float64]:
    """(N,) area over that of the ellipse with the same second moments."""
    minor, major = blobs.axes
    moments = (minor + PIXEL_MOMENT) * (major + PIXEL_MOMENT)
    return np.asarray(blobs.area / (4 * np.pi * np.sqrt(moments)))


def convexity(blobs: BlobTable) -> NDArray[np.float64]:
    """(N,) share of the pixels with their centers in the convex hull of all centers.

    The area of the hull is the number of its pixels, those on its sides half, less one (Pick 1899).
    It is 1 for a rod at any angle, whose steps are necks of its own.
    """
    v, left, right = blobs.runs.ends()
    ends = np.stack([left, v, right - 1, v], axis=1).astype(np.int32).reshape(-1, 2)
    hulls = [cv2.convexHull(part)[:, 0] for part in np.split(ends, 2 * blobs.first_run[1:])]
    sides = [np.gcd(*np.abs(hull - np.roll(hull, 1, axis=0)).T).sum() for hull in hulls]
    area = [cv2.contourArea(hull) for hull in hulls]
    return np.asarray(blobs.area / (np.array(area) + np.array(sides) / 2 + 1))


def _whole(mask: NDArray[np.float32]) -> NDArray[np.uint8]:
    """A mask without its holes, such as highlights, and with a margin of one pixel."""
    whole = np.pad(mask, 1).astype(np.uint8)
    cv2.floodFill(whole, None, (0, 0), 2)
    return np.asarray(whole != 2, np.uint8)


def _centers(mask: NDArray[np.uint8]) -> NDArray[np.float64]:
    """(K, 2) centers of the discs in a mask with a margin, u, v; none if it is something else."""
    distance = distance_of(mask)
    core = cores(distance, SHALLOW_NECK)
    if core is None:
        return np.zeros((0, 2))
    count, part = cv2.connectedComponents(core.view(np.uint8))
    peak = [(distance * (part == k)).argmax() for k in range(1, count)]
    v, u = np.divmod(peak, mask.shape[1])
    row, column = mask.nonzero()
    away = np.hypot(column[:, None] - u, row[:, None] - v) - distance[v, u]
    is_covered = (away <= 0.5).any(axis=1).mean() >= LEAST_COVERED
    return np.stack([u, v], axis=1) - 1.0 if is_covered else np.zeros((0, 2))
