"""Joins the pieces of an object whose color lies between two reference colors."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import connect
from colortrack_ros.detection.blobs import find_runs
from colortrack_ros.detection.blobs import positions
from colortrack_ros.detection.blobs import Runs
from colortrack_ros.detection.blobs import touching
from colortrack_ros.detection.label_image import LabelImage

OTHER_SHARE = 0.5
"""Least share of a piece that must also have the larger one's color: most of it is then on that
side of the surface between the two."""

Within = Callable[[NDArray[np.intp], NDArray[np.uint8]], NDArray[np.bool_]]
"""Returns (N,) whether pixels, counted as in Runs, are within tolerance of the labels' colors."""


def join_pieces(image: LabelImage, within: Within) -> None:
    """Decide between several colors by component, not by pixel, in place.

    A component takes the label of a larger one that it touches: the largest of those with a color
    that most of its pixels also match. Components that have taken its label follow.

    :param image: each pixel with the nearest color that it is within tolerance of.
    """
    runs = find_runs(image)
    count, component = connect(runs)
    length = runs.end - runs.start
    area = np.asarray(np.bincount(component, length, count), np.float64)
    small, large = _neighbors(runs, component, area)
    if not len(small):
        return
    order = np.argsort(component, kind='stable')
    first = np.searchsorted(component[order], np.arange(count + 1))
    size = (first[1:] - first[:-1])[small]
    pair = np.repeat(np.arange(len(small)), size)
    run = order[np.arange(len(pair)) + np.repeat(first[small] - np.cumsum(size) + size, size)]
    label = np.zeros(count, np.uint8)
    label[component] = runs.label
    pair = np.repeat(pair, length[run])
    is_other = within(positions(runs.take(run)), label[large[pair]])
    joined = np.bincount(pair, is_other, len(small)) >= OTHER_SHARE * area[small]
    small, large = small[joined], large[joined]
    target = np.arange(count)
    # The last write wins: the largest.
    by_area = np.lexsort((-large, area[large]))
    target[small[by_area]] = large[by_area]
    while ((above := target[target]) != target).any():
        target = above
    changed = target[component] != component
    pixels = np.repeat(label[target[component[changed]]], length[changed])
    image.padded.reshape(-1)[positions(runs.take(changed))] = pixels


def _neighbors(
    runs: Runs, component: NDArray[np.intp], area: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs of touching components, each once: the smaller (if equal, the later) and the other."""
    upper, lower = touching(runs)
    (left,) = (runs.start[1:] == runs.end[:-1]).nonzero()
    pairs = component[np.stack([np.append(upper, left), np.append(lower, left + 1)])]
    # Components are numbered in raster order.
    first, last = pairs.min(axis=0), pairs.max(axis=0)
    first, last = np.divmod(np.unique((first * len(area) + last)[first != last]), len(area))
    is_less = area[first] < area[last]
    return np.where(is_less, first, last), np.where(is_less, last, first)
