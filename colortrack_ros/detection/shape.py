"""Which blobs have the shape of what is looked for."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import Blobs

if TYPE_CHECKING:
    from colortrack_ros.detection.config import DetectorConfig

PIXEL = 1 / 12
"""Second moment of a pixel about its center, on each axis [px^2]."""


def aspect(blobs: Blobs) -> NDArray[np.float64]:
    """Minor over major axis of the ellipse with the blob's second moments."""
    minor, major = blobs.axes
    return np.sqrt((minor + PIXEL) / (major + PIXEL))


def extent(blobs: Blobs) -> NDArray[np.float64]:
    """Area over that of the bounding box; pi / 4 for a disc."""
    return blobs.area / (blobs.box[:, 2] * blobs.box[:, 3])


def circularity(blobs: Blobs) -> NDArray[np.float64]:
    """Area^2 over 2 pi times the moment of inertia, 1 for a disc (Zunic 2010).

    Unlike 4 pi A / P^2 it does not suffer from the ragged outline of small blobs.
    """
    inertia = np.sum(blobs.axes, axis=0) + 2 * PIXEL
    return np.minimum(blobs.area / (2 * np.pi * inertia), 1)


def solidity(blobs: Blobs) -> NDArray[np.float64]:
    """Area over that of the convex hull."""
    v, left, right = blobs.runs.ends()
    corners = np.stack([left, v, right, v, left, v + 1, right, v + 1], axis=1).astype(np.int32)
    parts = np.split(corners.reshape(-1, 2), 4 * blobs.first_run[1:])
    hulls = [cv2.contourArea(cv2.convexHull(part)) for part in parts if len(part)]
    return blobs.area / np.array(hulls)


MEASURES: dict[str, Callable[[Blobs], NDArray[np.float64]]] = {
    'min_aspect': aspect,
    'min_extent': extent,
    'min_circularity': circularity,
    'min_solidity': solidity,
}
"""Parameters and what has to be at least as much, 0..1."""


def keep_shapes(blobs: Blobs, config: 'DetectorConfig') -> Blobs:
    """The blobs up to max_area with all the shapes asked for; 0 asks for nothing."""
    if (large := blobs.area > config.max_area).any():
        blobs = blobs.take(~large)
    for name, measure in MEASURES.items():
        least = getattr(config, name)
        if least > 0 and len(blobs.area):
            blobs = blobs.take(measure(blobs) >= least)
    return blobs
