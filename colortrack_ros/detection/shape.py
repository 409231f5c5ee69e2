"""Which blobs have the shape of what is looked for."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import Blobs

if TYPE_CHECKING:
    from colortrack_ros.detection.config import DetectorConfig

PIXEL = np.eye(2) / 12
"""Second moments of a pixel about its center [px^2]."""


def aspect(blobs: Blobs) -> NDArray[np.float64]:
    """Minor over major axis of the ellipse with the blob's second moments."""
    (uu, uv), (_, vv) = (blobs.spread + PIXEL).transpose(1, 2, 0)
    middle, half = (uu + vv) / 2, np.hypot((uu - vv) / 2, uv)
    return np.sqrt((middle - half) / (middle + half))


def extent(blobs: Blobs) -> NDArray[np.float64]:
    """Area over that of the bounding box; pi / 4 for a disc."""
    return blobs.area / (blobs.box[:, 2] * blobs.box[:, 3])


def circularity(blobs: Blobs) -> NDArray[np.float64]:
    """Area^2 over 2 pi times the moment of inertia, 1 for a disc (Zunic 2010).

    Unlike 4 pi A / P^2 it does not suffer from the ragged outline of small blobs.
    """
    inertia = np.trace(blobs.spread + PIXEL, axis1=1, axis2=2)
    return np.minimum(blobs.area / (2 * np.pi * inertia), 1)


def solidity(blobs: Blobs) -> NDArray[np.float64]:
    """Area over that of the convex hull."""
    v, left = np.divmod(blobs.runs.start, blobs.runs.stride)
    right = left + blobs.runs.end - blobs.runs.start
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
    """The blobs that have all the shapes asked for; a parameter of 0 asks for nothing."""
    for name, measure in MEASURES.items():
        least = getattr(config, name)
        if least > 0 and len(blobs.area):
            blobs = blobs.take(measure(blobs) >= least)
    return blobs
