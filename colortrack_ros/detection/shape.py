"""Shape filter: keeps blobs of the configured sizes and shapes."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.reference import MAX_AREA
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import parameter

PIXEL_MOMENT = 1 / 12
"""Second moment of a unit square about its center, per axis [px^2]: the variance of a position that
is somewhere within its pixel."""


@dataclass(frozen=True)
class ShapeConfig(Config):
    """Which blobs are objects, by size and shape."""

    min_area: int = parameter(
        20,
        'Blobs with fewer pixels are dropped; up to 20, small things of colors without a tolerance '
        'are found while nothing larger of them is in sight.',
        unit='px',
        limits=(1, MAX_AREA),
    )
    max_area: int = parameter(
        MAX_AREA, 'Blobs with more pixels are dropped.', unit='px', limits=(1, MAX_AREA)
    )
    min_aspect: float = parameter(
        0.0, "Least ratio of a blob's minor to its major axis.", limits=(0.0, 1.0)
    )
    min_extent: float = parameter(
        0.0, "Least ratio of a blob's area to that of its box.", limits=(0.0, 1.0)
    )
    min_circularity: float = parameter(
        0.0,
        'Least circularity of a blob, 1 for a disc; a ball is above 0.9.',
        limits=(0.0, 1.0),
    )
    min_solidity: float = parameter(
        0.0, "Least ratio of a blob's area to that of its convex hull.", limits=(0.0, 1.0)
    )

    def check(self) -> None:
        """Require that min_area does not exceed max_area."""
        super().check()
        if self.max_area < self.min_area:
            raise ValueError(
                f'max_area: expected at least min_area, {self.min_area} px, got {self.max_area}'
            )


def aspect(blobs: BlobTable) -> NDArray[np.float64]:
    """Minor over major axis of the ellipse with the blob's second moments."""
    minor, major = blobs.axes
    return np.sqrt((minor + PIXEL_MOMENT) / (major + PIXEL_MOMENT))


def extent(blobs: BlobTable) -> NDArray[np.float64]:
    """Area over that of the bounding box; pi / 4 for a disc."""
    return blobs.area / (blobs.box[:, 2] * blobs.box[:, 3])


def circularity(blobs: BlobTable) -> NDArray[np.float64]:
    """Area^2 over 2 pi times the moment of inertia, 1 for a disc (Zunic 2010).

    Unlike 4 pi A / P^2, it is robust to the ragged outlines of small blobs.
    """
    minor, major = blobs.axes
    inertia = minor + major + 2 * PIXEL_MOMENT
    return np.minimum(blobs.area / (2 * np.pi * inertia), 1)


def solidity(blobs: BlobTable) -> NDArray[np.float64]:
    """Area over that of the convex hull."""
    v, left, right = blobs.runs.ends()
    corners = np.stack([left, v, right, v, left, v + 1, right, v + 1], axis=1).astype(np.int32)
    parts = np.split(corners.reshape(-1, 2), 4 * blobs.first_run[1:])
    hulls = [cv2.contourArea(cv2.convexHull(part)) for part in parts if len(part)]
    return blobs.area / np.array(hulls)


MEASURES: dict[str, Callable[[BlobTable], NDArray[np.float64]]] = {
    'min_aspect': aspect,
    'min_extent': extent,
    'min_circularity': circularity,
    'min_solidity': solidity,
}
"""The measure, 0..1, for which each parameter is the minimum."""


def keep_shapes(blobs: BlobTable, config: ShapeConfig) -> BlobTable:
    """Keep the blobs that meet all limits; 0 is no limit."""
    for name, measure in MEASURES.items():
        least = getattr(config, name)
        if least > 0 and len(blobs.area):
            blobs = blobs.take(measure(blobs) >= least)
    return blobs
