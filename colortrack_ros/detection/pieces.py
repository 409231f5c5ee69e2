"""Pieces that a thing falls into where its color lies between two that are looked for."""

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
"""Share of a piece that must be of the larger one's color, too: that is the side of the surface
between both that most of it is on."""

Within = Callable[[NDArray[np.intp], NDArray[np.uint8]], NDArray[np.bool_]]
"""(N,) whether pixels, counted as in Runs, are within tolerance of the colors with these labels."""


def join_pieces(image: LabelImage, within: Within) -> None:
    """Let components be decided, not single pixels, which of several colors they are, in place.

    A component takes the label of a larger one that it touches, the largest of those whose color
    most of its pixels have as well; what has taken its label goes with it.

    :param image: each pixel with the nearest of the colors that it is within tolerance of.
    """
    runs = find_runs(image)
    count, component = connect(runs)
    length = runs.end - runs.start
    area = np.asarray(np.bincount(component, length, count), np.float64)
    small, large = _neighbors(runs, component, area)
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
    # The last one that is written stays: the largest.
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
    """Components that touch, each pair once: the smaller or, if equal, the later, and the other."""
    upper, lower = touching(runs)
    (left,) = (runs.start[1:] == runs.end[:-1]).nonzero()
    pairs = component[np.stack([np.append(upper, left), np.append(lower, left + 1)])]
    # Components count in raster order.
    first, last = pairs.min(axis=0), pairs.max(axis=0)
    first, last = np.divmod(np.unique((first * len(area) + last)[first != last]), len(area))
    is_less = area[first] < area[last]
    return np.where(is_less, first, last), np.where(is_less, last, first)
