"""Connected components of a label image and their moments, computed from horizontal runs.

A picture of two million pixels with five objects has a few hundred runs, so everything after the
one pass that finds them is cheap.
"""

from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.label_image import WORD

MULTIPLES = np.array([[2], [1], [12], [2], [1]])
"""Of the sums of u, v, u^2, u v and v^2, such that those over runs are integers."""


@dataclass(frozen=True)
class Runs(Columns):
    """Maximal horizontal runs of one label, in raster order.

    :param start, end: (R,) first position and one past the last, counted through an image of width
        stride.
    :param label: (R,) label of the pixels.
    :param stride: width of the padded image that positions refer to [px].
    """

    start: NDArray[np.intp]
    end: NDArray[np.intp]
    label: NDArray[np.uint8]
    stride: int

    @cached_property
    def length(self) -> NDArray[np.intp]:
        """(R,) number of pixels."""
        return self.end - self.start

    @cached_property
    def row(self) -> NDArray[np.intp]:
        """(R,) row of the picture."""
        return self.start // self.stride

    @cached_property
    def left(self) -> NDArray[np.intp]:
        """(R,) first column."""
        return self.start - self.row * self.stride

    @cached_property
    def right(self) -> NDArray[np.intp]:
        """(R,) one past the last column."""
        return self.left + self.length

    def ends(self) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
        """(R,) each: row, first column, and one past the last column."""
        return self.row, self.left, self.right


@dataclass(frozen=True)
class BlobTable:
    """Connected components, largest area first, and in raster order at equal area.

    :param label: (N,) label of the pixels.
    :param area: (N,) number of pixels, m00.
    :param mean: (N, 2) centroid u, v [px].
    :param spread: (N, 2, 2) central second moments over the area [px^2].
    :param box: (N, 4) left, top, width, height [px].
    :param runs: the runs of all blobs, grouped by blob.
    :param first_run: (N,) index into runs of each blob's first run.
    :param run_count: (N,) number of runs.
    """

    label: NDArray[np.uint8]
    area: NDArray[np.int64]
    mean: NDArray[np.float64]
    spread: NDArray[np.float64]
    box: NDArray[np.int64]
    runs: Runs
    first_run: NDArray[np.intp]
    run_count: NDArray[np.intp]

    @cached_property
    def axes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(N,) each: second moments along the minor and the major axis [px^2]."""
        (uu, uv), (_, vv) = self.spread.transpose(1, 2, 0)
        middle, half = (uu + vv) / 2, np.hypot((uu - vv) / 2, uv)
        return np.maximum(middle - half, 0), middle + half

    def inside(self, width: int, height: int) -> NDArray[np.bool_]:
        """(N,) whether a blob is clear of the border of a picture of this size."""
        low = self.box[:, :2]
        is_inside = (low > 0) & (low + self.box[:, 2:] < (width, height))
        return np.asarray(is_inside.all(axis=1))

    def take(self, kept: NDArray[np.bool_]) -> 'BlobTable':
        """A subset of the blobs, in the same order, with a copy of their runs."""
        if kept.all():
            return self
        columns = {k: v[kept] for k, v in vars(self).items() if isinstance(v, np.ndarray)}
        columns['first_run'] = np.cumsum(columns['run_count']) - columns['run_count']
        return replace(self, runs=self.runs.take(np.repeat(kept, self.run_count)), **columns)


Connect = Callable[[Runs], tuple[int, NDArray[np.intp]]]
"""Returns the number of components, and (R,) the component of each run."""


def find_runs(image: LabelImage) -> Runs:
    """Find the runs of a label image."""
    words, labels = image.content()
    flat = labels.reshape(-1)
    edge = np.ones(len(flat) + 1, bool)
    np.not_equal(flat[1:], flat[:-1], out=edge[1:-1])
    edge[WORD:-1:WORD] |= words[1:] - words[:-1] > 1
    (bound,) = edge.nonzero()
    label = flat.take(bound[:-1])
    (run,) = label.nonzero()
    first, last = bound.take(run), bound.take(run + 1) - 1
    start = words.take(first >> 3) * WORD + (first & 7)
    end = words.take(last >> 3) * WORD + (last & 7) + 1
    return Runs(start, end, label.take(run), image.stride)


def connect(runs: Runs) -> tuple[int, NDArray[np.intp]]:
    """Find the 8-connected components of equal label.

    Each component is a tree of runs rooted at its first run. Trees that touch are merged, all at
    once, until none do.

    :returns: their number, and (R,) the component of each run, in raster order.
    """
    upper, lower = touching(runs)
    root = number = np.arange(len(runs.start))
    apart = runs.label[upper] == runs.label[lower]
    while apart.any():
        upper, lower = upper[apart], lower[apart]
        one, other = root[upper], root[lower]
        root = root.copy()
        np.minimum.at(root, np.maximum(one, other), np.minimum(one, other))
        while ((above := root.take(root)) != root).any():
            root = above.take(above)
        apart = root[upper] != root[lower]
    is_first = root == number
    return int(np.count_nonzero(is_first)), (is_first.cumsum() - 1)[root]


def touching(runs: Runs) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Find pairs of touching runs in adjacent rows, upper and lower, whatever their labels.

    Two runs touch if one, moved down a row and widened by a pixel on both sides, overlaps the
    other. Runs are sorted, so those it overlaps are consecutive.
    """
    first = runs.end.searchsorted(runs.start + runs.stride, 'left')
    behind = runs.start.searchsorted(runs.end + runs.stride, 'right')
    met = np.maximum(behind - first, 0)
    upper = np.arange(len(met)).repeat(met)
    return upper, np.arange(len(upper)) + (first - met.cumsum() + met).repeat(met)


def as_one(runs: Runs) -> tuple[int, NDArray[np.intp]]:
    """Treat all runs as one component, connected or not."""
    return min(len(runs.start), 1), np.zeros(len(runs.start), np.intp)


def positions(runs: Runs) -> NDArray[np.intp]:
    """Positions of the pixels in runs, v stride + u, run by run."""
    length = runs.length
    return np.arange(length.sum()) + (runs.end - length.cumsum()).repeat(length)


def clear(image: LabelImage, runs: Runs) -> None:
    """Set the pixels of runs to 0, in place."""
    image.padded.reshape(-1)[positions(runs)] = 0


def find_blobs(
    image: LabelImage, min_area: int, max_area: float = np.inf, connect: Connect = connect
) -> BlobTable:
    """Find the 8-connected components of equal label, by Pegoretti 2021, (2.9) to (2.11).

    All sums are of integers, and exact.

    :param image: the labels.
    :param min_area, max_area: range of areas to keep [px].
    :param connect: groups runs into components.
    """
    runs = find_runs(image)
    count, component = connect(runs)
    area = np.bincount(component, runs.length, count).astype(np.int64)
    (kept,) = ((area >= min_area) & (area <= max_area)).nonzero()
    kept = kept[(-area[kept]).argsort(kind='stable')]
    rank = np.full(count, len(kept))
    rank[kept] = np.arange(len(kept))
    blob = rank[component]
    order = blob.argsort(kind='stable')
    first = blob[order].searchsorted(np.arange(len(kept) + 1))
    return _measure(runs.take(order[: first[-1]]), first, area[kept])


def _measure(runs: Runs, first: NDArray[np.intp], area: NDArray[np.int64]) -> BlobTable:
    """Compute moments and boxes of N blobs.

    :param first: (N + 1,) index of the first run of each blob, and the number of runs.
    """
    first, count = first[:-1], first[1:] - first[:-1]
    if not len(first):
        none = np.zeros((0, 4))
        mean, spread = none[:, :2], none.reshape(0, 2, 2)
        return BlobTable(runs.label, area, mean, spread, none.astype(np.int64), runs, first, count)
    row, left, right = runs.ends()
    top, bottom = row[first], row[first + count - 1]
    box_left = np.minimum.reduceat(left, first)
    width = np.maximum.reduceat(right, first) - box_left
    # Coordinates relative to the corner of the box keep the sums small. The sums of u and u^2 over
    # a run are length ends / 2 and length (3 ends^2 + length^2 - 1) / 12.
    row, ends = row - top.repeat(count), left + right - (2 * box_left + 1).repeat(count)
    length = runs.length
    squares = 3 * ends * ends + length * length - 1
    sums = length * np.array([ends, row, squares, ends * row, row * row])
    u, v, uu, uv, vv = np.add.reduceat(sums, first, axis=1) / (MULTIPLES * area)
    spread = np.array([uu - u * u, uv - u * v, uv - u * v, vv - v * v]).T
    return BlobTable(
        runs.label[first],
        area,
        np.array([u + box_left, v + top]).T,
        spread.reshape(-1, 2, 2),
        np.array([box_left, top, width, bottom - top + 1]).T,
        runs,
        first,
        count,
    )


def sample_pixels(blobs: BlobTable, most: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Sample pixels evenly over each blob in raster order, or all if there are few.

    :param most: number of pixels taken from larger blobs.
    :returns: the blob and the position, counted as in Runs, of each pixel.
    """
    taken = np.minimum(blobs.area, most)
    blob = np.arange(len(taken)).repeat(taken)
    number = np.arange(len(blob)) - (taken.cumsum() - taken).repeat(taken)
    before = blobs.area.cumsum() - blobs.area
    pixel = before[blob] + number * blobs.area[blob] // taken[blob]
    behind = blobs.runs.length.cumsum()
    run = behind.searchsorted(pixel, 'right')
    return blob, blobs.runs.end[run] - behind[run] + pixel
