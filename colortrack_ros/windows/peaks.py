"""Peaks between samples."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def vertex(values: NDArray[np.floating[Any]], k: int) -> float:
    """Return the vertex of the parabola through a peak and its neighbors, within 0.5 of k.

    :param values: (n,).
    :param k: index of the highest value.
    :return: fractional index; k where a neighbor is missing.
    """
    if not 0 < k < len(values) - 1:
        return float(k)
    before, here, after = values[k - 1 : k + 2].tolist()
    curvature = before + after - 2 * here
    if curvature >= 0:
        return float(k)
    return k + min(max((before - after) / (2 * curvature), -0.5), 0.5)
