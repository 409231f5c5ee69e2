"""Which detections come into question for which track."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


def candidates(center: Floats, half: Floats, points: Floats) -> tuple[Indices, Indices]:
    """All points inside each of N rectangles.

    :param center: (N, 2) [px].
    :param half: (N, 2) half width and half height [px].
    :param points: (M, 2) [px].
    :return: indices (K,) of rectangles, ascending, and (K,) of points.
    """
    inside = np.abs(points - center[:, None]) <= half[:, None]
    rectangle, point = np.nonzero(inside[..., 0] & inside[..., 1])
    return rectangle, point
