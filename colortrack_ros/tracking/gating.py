"""Which detections come into question for which track."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

FEW = 10_000
"""So many comparisons are faster than sorting."""


def candidates(center: Floats, half: Floats, points: Floats) -> tuple[Indices, Indices]:
    """All points inside each of N rectangles.

    Few are compared all with all. Else the points are sorted into horizontal strips, and by u
    within a strip; what a rectangle holds of a strip is then one run of them, which two binary
    searches find.

    :param center: (N, 2) [px].
    :param half: (N, 2) half width and half height [px].
    :param points: (M, 2) [px].
    :return: indices (K,) of rectangles, ascending, and (K,) of points.
    """
    if len(center) * len(points) <= FEW:
        (u, v), (x, y), (width, height) = points.T, center.T[..., None], half.T[..., None]
        rectangle, point = np.nonzero((np.abs(u - x) <= width) & (np.abs(v - y) <= height))
        return rectangle, point
    start, end = points.min(axis=0), points.max(axis=0)
    tall = float(np.minimum(half[:, 1], end[1] - start[1]).mean())
    height = max(2 * tall, float(end[1] - start[1]) / 1000, 1.0)
    row_of = np.floor((points[:, 1] - start[1]) / height)
    length = float(end[0] - start[0]) + 2.0
    key = row_of * length + (points[:, 0] - start[0] + 1)
    order = np.argsort(key, kind='stable')
    low = np.clip(center - half - start, -1, end - start + 1)
    high = np.clip(center + half - start, -1, end - start + 1)
    top, bottom = np.floor(low[:, 1] / height), np.floor(high[:, 1] / height)
    rectangle, row = _runs(top, (bottom - top + 1).astype(np.intp))
    first = np.searchsorted(key[order], row * length + low[rectangle, 0] + 0.999999)
    last = np.searchsorted(key[order], row * length + high[rectangle, 0] + 1.000001)
    run, place = _runs(first, last - first)
    rectangle, point = rectangle[run], order[place]
    inside = (np.abs(points[point] - center[rectangle]) <= half[rectangle]).all(axis=1)
    return rectangle[inside], point[inside]


def _runs(first: NDArray, length: Indices) -> tuple[Indices, NDArray]:
    """Runs of successive numbers, one after the other.

    :param first: (N,) where each run starts.
    :param length: (N,) of each run.
    :return: (K,) index of the run, and (K,) the number.
    """
    run = np.repeat(np.arange(len(length)), length)
    offset = np.arange(len(run)) - (np.cumsum(length) - length)[run]
    return run, first[run] + offset
