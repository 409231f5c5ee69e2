"""How well the centroid of a blob is known."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import Blobs

BOUNDARY_VARIANCE = 0.25
"""Variance of a boundary pixel's membership: as likely in as out."""

PIXELATION = 1 / 12
"""Variance of a position within its pixel [px^2], all that is known of a single one."""


def centroid_covariance(blobs: Blobs, width: int, height: int) -> NDArray[np.float64]:
    """Measurement covariance of each centroid.

    Two independent errors, with N the area, S the central second moments of the blob and B the
    length of its outline, that of the ellipse-like shape in its box, pi (w + h) / 2:

    - each outline pixel is in or out by chance. The second moments of an outline about its center
      are twice those of the area within, so the sum over the outline is B 2 S BOUNDARY_VARIANCE,
      and over N^2 for the mean;
    - the grid: a blob of N pixels is known to PIXELATION / N.

    A blob that touches the picture's border goes on behind it, nobody knows how far. With an
    extent e, the larger side of its box, and a hidden part between nothing and e, its true center
    is up to e / 2 farther out: e^2 / 12 is added in that direction.

    :param width, height: of the picture [px].
    :returns: (N, 2, 2) [px^2], positive definite.
    """
    area = blobs.area[:, None, None]
    left, top, box_width, box_height = blobs.box.T
    outline = (np.pi / 2 * (box_width + box_height))[:, None, None]
    covariance = 2 * BOUNDARY_VARIANCE * outline / area**2 * blobs.spread
    covariance += PIXELATION / area * np.eye(2)
    hidden = np.maximum(box_width, box_height) ** 2 / 12
    covariance[:, 0, 0] += np.where((left == 0) | (left + box_width == width), hidden, 0)
    covariance[:, 1, 1] += np.where((top == 0) | (top + box_height == height), hidden, 0)
    return covariance
