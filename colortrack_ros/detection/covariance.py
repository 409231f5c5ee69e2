"""How well the centroid of a blob is known."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import Blobs

OUTLINE_VARIANCE = 0.06
"""Variance of the membership of a pixel on the outline, which is in or out by chance."""

PIXELATION = 1 / 12
"""Variance of a position within its pixel [px^2], all that is known of a single one."""

FLOOR = 0.0028
"""What shading, blur and compression shift a whole outline by, at any size [px^2]."""

SMEAR = 0.004
"""Share of what makes a blob long: the ends of a smear fade unequally."""

ROUND = 1.1
"""Ratio of the second moments up to which a blob is not taken for a smear."""


def centroid_covariance(blobs: Blobs, width: int, height: int) -> NDArray[np.float64]:
    """Measurement covariance of each centroid.

    A sum of independent errors, with N the area, S the central second moments of the blob and B
    the length of its outline, that of the ellipse-like shape in its box, pi (w + h) / 2:

    - each outline pixel is in or out by chance. The second moments of an outline about its center
      are twice those of the area within: 2 S B OUTLINE_VARIANCE / N^2, which falls with the
      blob's diameter;
    - the grid: PIXELATION / N;
    - the smear of a moving object: SMEAR times what the major second moment has beyond ROUND
      times the minor one, up to twice the minor one: longer things are long by themselves;
    - FLOOR.

    A blob that touches the picture's border goes on behind it, nobody knows how far. With an
    extent e, the larger side of its box, and a hidden part between nothing and e, its true center
    is up to e / 2 farther out: e^2 / 12 is added in that direction.

    The constants are fitted to rendered balls of 8 to 50 px radius. What hides a part of the
    blob inside the picture does not show here.

    :param width, height: of the picture [px].
    :returns: (N, 2, 2) [px^2], positive definite.
    """
    area = blobs.area[:, None, None]
    left, top, box_width, box_height = blobs.box.T
    outline = (np.pi / 2 * (box_width + box_height))[:, None, None]
    covariance = 2 * OUTLINE_VARIANCE * outline / area**2 * blobs.spread
    minor, major = blobs.axes
    smear = SMEAR * np.clip(major - ROUND * minor, 0, 2 * minor)[:, None, None]
    covariance += (PIXELATION / area + smear + FLOOR) * np.eye(2)
    hidden = np.maximum(box_width, box_height) ** 2 / 12
    covariance[:, 0, 0] += np.where((left == 0) | (left + box_width == width), hidden, 0)
    covariance[:, 1, 1] += np.where((top == 0) | (top + box_height == height), hidden, 0)
    return covariance
