"""Shades that tell an object from its surroundings, from the pixels of examples.

The pixels of an object fill a curved, narrow region of CIELAB, from its dark to its light side;
those of a door of nearly its color fill another one right beside it. Where both are common, the
ratio of their densities decides. A few shades of each then stand for the regions: the surface half
way between the nearest ones follows the one between the regions, and costs nothing at run time.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from scipy.sparse import csr_array
from scipy.spatial.distance import cdist

from colortrack_ros.detection.cells import CELLS
from colortrack_ros.detection.cells import lab_of_cells
from colortrack_ros.detection.color_table import look_up
from colortrack_ros.detection.extent import DEEPER
from colortrack_ros.detection.extent import LARGEST_SHARE
from colortrack_ros.detection.growth import FEWEST_PIXELS
from colortrack_ros.detection.growth import growth_of
from colortrack_ros.detection.growth import MOST_GROWTH
from colortrack_ros.detection.growth import NEAR
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.growth import outline_end
from colortrack_ros.detection.growth import OUTLINE_WIDTH
from colortrack_ros.detection.growth import SIZES
from colortrack_ros.detection.growth import SLOPE_STEPS
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.lab import rgb_from_lab
from colortrack_ros.detection.morphology import EROSION
from colortrack_ros.detection.reference import LAB_RANGES

Shades = NDArray[np.float64]

LIGHTNESS_STRETCH = 1.5
"""Ratio of the half axis of L to those of a and b, around shades that include an object's lightness
already. Chosen: `python benchmark/taught.py` finds as much with 1, and with 2.5 colors of the room
are nearer to each other."""

SHAPE_OF_SHADES = np.array([LIGHTNESS_STRETCH, 1.0, 1.0])
"""Half axes along L, a, b for measuring distances from shades."""

LAB_BIN = 2.0
"""Side of the bins in which densities are smoothed [CIELAB units]: the size of a cell."""

LEAST_LAB = np.array([low for _, low, _ in LAB_RANGES])
"""Least L, a, b."""

SMOOTHING = 2.3
"""Standard deviation of the smoothing [CIELAB units]: the just noticeable difference (Mahy
1994)."""

SMOOTHING_REACH = 5
"""How far a pixel is smoothed [bins]: 4 standard deviations, where gaussian_filter ends."""

SHADE_RADIUS = NEAR / 2
"""Radius within which one shade stands for all [CIELAB units]."""

MOST_BINS = 2048
"""Number of bins that are condensed to shades, the most frequent ones: bounds time and memory."""

SHADES_SHARE, MOST_SHADES_TAUGHT = 0.97, 64
"""Share of the pixels of the examples that are near to their shades, without outlines, and
the largest number of shades, which bounds the time to build a table. Assumed."""

SEEN_SHARE = 0.8
"""Share of the pixels of an example that are near to the shades of the others, so that what is
between them is included: without highlights and outlines. Assumed."""

RATIOS = 2.0 ** np.arange(1, 6.5, 0.5)
"""Ratios of densities to try, above which a color belongs to what is not the object. Below 2, the
surroundings would take as much from the object as they lose. Assumed."""

SPILLED_AREA = 4.0
"""Least area of a click's region that has run into the surroundings, over that of the others:
twice as near, an object has four times the area. Assumed."""

WHOLE_SHARE = 2 / 3
"""Least share of the pixels of an object, eroded, that are one piece, compared to those with all
gaps of one pixel filled. Single pixels lost to the surroundings cost nine each in the erosion.
`python benchmark/taught.py --constants`: with more, more is false; with less, centroids shift."""


@dataclass(frozen=True)
class Part:
    """The part of a picture that an example is.

    :param mask: (H, W) 1 inside, else 0.
    :param cells: (H, W) of its pixels.
    :param shown: (N,) cells of the pixels that are shown by themselves, near a click.
    :param is_grown: whether the mask has grown beyond them.
    """

    mask: NDArray[np.uint8]
    cells: NDArray[np.uint16]
    shown: NDArray[np.uint16]
    is_grown: bool

    @property
    def shares(self) -> NDArray[np.float64]:
        """(65536,) share of its pixels in each cell."""
        return _shares(self.cells[self.mask > 0])

    def wholeness(self, mine: NDArray[np.bool_]) -> float:
        """Share of its largest piece after erosion, compared to it without gaps.

        :param mine: (65536,) which cells the color includes.
        """
        label = np.empty(self.cells.shape, np.uint8)
        look_up(mine.view(np.uint8), self.cells, label)
        label = np.pad(label & self.mask, 2)
        filled = cv2.erode(cv2.morphologyEx(label, cv2.MORPH_CLOSE, EROSION), EROSION)
        pieces = cv2.connectedComponentsWithStats(cv2.erode(label, EROSION))[2][1:]
        largest = pieces[:, cv2.CC_STAT_AREA].max(initial=0)
        return float(largest / max(np.count_nonzero(filled), 1))


def _shares(cells: NDArray[np.uint16]) -> NDArray[np.float64]:
    """(65536,) share of each cell."""
    return np.bincount(cells.reshape(-1), minlength=CELLS) / max(cells.size, 1)


def _density(shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """(65536,) smoothed density of pixels in CIELAB at each cell."""
    bins = np.rint((lab_of_cells(np.arange(CELLS)) - LEAST_LAB) / LAB_BIN).astype(int)
    (filled,) = shares.nonzero()
    low = bins[filled].min(axis=0) - SMOOTHING_REACH
    size = bins[filled].max(axis=0) + SMOOTHING_REACH + 1 - low
    bins -= low
    grid = np.zeros(size)
    np.add.at(grid, tuple(bins[filled].T), shares[filled])
    density = np.zeros(len(shares))
    near = ((bins >= 0) & (bins < size)).all(axis=1)
    smooth = gaussian_filter(grid, SMOOTHING / LAB_BIN, mode='constant')
    density[near] = smooth[tuple(bins[near].T)]
    return density


def _shades_of(shares: NDArray[np.float64], share: float) -> Shades:
    """(N, 3) shades that stand for most of the pixels, the most frequent first."""
    (filled,) = shares.nonzero()
    color, weight = lab_of_cells(filled), shares[filled]
    cube = np.unique(np.floor(color / LAB_BIN), axis=0, return_inverse=True)[1].reshape(-1)
    weights = np.bincount(cube, weight)
    sums = np.stack([np.bincount(cube, weight * axis) for axis in color.T], axis=1)
    order = np.argsort(-weights, kind='stable')[:MOST_BINS]
    left, means = weights[order], sums[order] / weights[order, None]
    near = csr_array(cdist(means, means, 'sqeuclidean') < SHADE_RADIUS**2)
    rest = (1 - share) * left.sum()
    shades: list[NDArray[np.float64]] = []
    while left.sum() > rest and len(shades) < MOST_SHADES_TAUGHT:
        center = int((near @ left).argmax())
        mine = near.indices[near.indptr[center] : near.indptr[center + 1]]
        if not left[mine].any():
            break
        shades.append(np.average(means[mine], axis=0, weights=left[mine]))
        left[mine] = 0.0
    return lab_from_rgb(rgb_from_lab(shades))


@dataclass(frozen=True)
class Discrimination:
    """Shades that tell an object from its surroundings.

    :param samples: (S, 3) of the object, in CIELAB, the most frequent first.
    :param others: (O, 3) of its surroundings.
    :param shares: (examples, 65536) of the pixels of each example that are told to be the object.
    """

    samples: Shades
    others: Shades
    shares: NDArray[np.float64]

    def others_within(self, reach: float) -> Shades:
        """Those of the others that bound the samples' ellipsoids, at least the nearest."""
        away = nearest_sample(self.others, self.samples, SHAPE_OF_SHADES)
        return self.others[away <= max(2 * reach, away.min(initial=np.inf))]

    def least_reach(self) -> float:
        """Least half axis of a and b around the samples that includes other views of the object.

        Views between two examples are at most half as far from them as they are from each other.
        """
        least = _distance_within(self.shares.sum(axis=0), self.samples, SHADES_SHARE)
        for k, share in enumerate(self.shares):
            rest = np.delete(self.shares, k, axis=0).sum(axis=0)
            if share.any() and rest.any():
                shades = _shades_of(rest, SHADES_SHARE)
                least = max(least, _distance_within(share, shades, SEEN_SHARE) / 2)
        return least

    def reach(self, counts: NDArray[np.float64]) -> float | None:
        """Half axis of a and b, up to where others begin; None if the color fills the pictures.

        :param counts: (65536,) of :func:`count_colors`.
        """
        (filled,) = counts.nonzero()
        color, number = lab_of_cells(filled), counts[filled]
        away = nearest_sample(color, self.samples, SHAPE_OF_SHADES)
        mine = away < nearest_sample(color, self.others, SHAPE_OF_SHADES)
        growth, count, larger = growth_of(number[mine], away[mine])
        sizes = SIZES[SLOPE_STEPS:-SLOPE_STEPS]
        is_out = (count < FEWEST_PIXELS) | (larger > LARGEST_SHARE * counts.sum())
        growth[is_out | (sizes < min(self.least_reach(), sizes[-1]))] = np.inf
        if not np.isfinite(growth).any():
            return None
        if len(self.others):
            # What is nearer to them is not counted: far out nothing is left to grow, and the
            # deepest valley is there. The first that ends is meant.
            lowest = np.minimum.accumulate(growth)
            outline = 2 * OUTLINE_WIDTH * np.sqrt(np.pi / np.maximum(count, 1))
            ends = (growth > lowest + outline) & (lowest < MOST_GROWTH)
            lowest = lowest[ends.argmax() if ends.any() else -1]
            return float(sizes[(growth <= lowest + DEEPER).argmax()])
        valley = int((growth <= growth.min() + DEEPER).argmax())
        return float(sizes[max(valley, outline_end(growth, float(count[valley]), valley))])


def _distance_within(shares: NDArray[np.float64], shades: Shades, share: float) -> float:
    """The distance from the nearest shade within which a share of the pixels is."""
    (filled,) = shares.nonzero()
    away = nearest_sample(lab_of_cells(filled), shades, SHAPE_OF_SHADES)
    order = np.argsort(away)
    behind = np.cumsum(shares[filled][order])
    return float(away[order][np.searchsorted(behind, share * behind[-1])])


def discriminate(mine: Sequence[Part], theirs: Sequence[Part]) -> Discrimination:
    """Find shades of the object, and of what is not it where the object is not denser.

    The least ratio of densities is taken that does not take the object to pieces.

    :param mine: examples of the object, at least one.
    :param theirs: examples of what is not it.
    """
    shares = np.array([part.shares for part in mine])
    their_shares = np.array([part.shares for part in theirs]).reshape(-1, CELLS)
    their_density = np.max([_density(share) for share in their_shares], axis=0, initial=0.0)
    densities = np.array([_density(share) for share in shares])
    spilled = _spilled(mine, shares, densities, their_density)
    for k in np.flatnonzero(spilled).tolist():
        shares[k] = _shares(mine[k].shown)
        densities[k] = _density(shares[k])
    density = densities.mean(axis=0)
    whole = [part for part, is_spilled in zip(mine, spilled, strict=True) if not is_spilled]
    best, most = None, -1.0
    for ratio in RATIOS if len(theirs) else RATIOS[-1:]:
        found, included = _divided(shares, their_shares, their_density > ratio * density)
        wholeness = min((part.wholeness(included) for part in whole), default=1.0)
        if wholeness > most:
            best, most = found, wholeness
        if wholeness >= WHOLE_SHARE:
            break
    assert best is not None
    return best


def _spilled(
    mine: Sequence[Part],
    shares: NDArray[np.float64],
    density: NDArray[np.float64],
    their_density: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """(examples,) which of them are mostly surroundings, into which a click's region has run.

    They are larger than the others, and have colors that are common there and not in the others.
    """
    if len(mine) == 1:
        return np.zeros(1, bool)
    area = np.array([np.count_nonzero(part.mask) for part in mine])
    is_large = area > SPILLED_AREA * np.array(
        [np.median(np.delete(area, k)) for k in range(len(area))]
    )
    is_large &= [part.is_grown for part in mine]
    rest = (density.sum(axis=0) - density) / (len(mine) - 1)
    doubted = (RATIOS[0] * their_density > density) & (their_density > RATIOS[0] * rest)
    return np.asarray(is_large & ((shares * doubted).sum(axis=1) > 0.5))


def _divided(
    shares: NDArray[np.float64], their_shares: NDArray[np.float64], are_theirs: NDArray[np.bool_]
) -> tuple[Discrimination, NDArray[np.bool_]]:
    """Shades for a division of the cells, and (65536,) which cells are nearer to the object's."""
    own = np.where(are_theirs, 0.0, shares)
    if not own.any():
        own = shares
    samples = _shades_of(own.sum(axis=0), SHADES_SHARE)
    theirs = np.where(are_theirs, their_shares, 0.0).sum(axis=0)
    others = _shades_of(theirs, 1.0) if theirs.any() else np.empty((0, 3))
    (filled,) = (shares.any(axis=0)).nonzero()
    color, included = lab_of_cells(filled), np.zeros(CELLS, bool)
    away = nearest_sample(color, samples, SHAPE_OF_SHADES)
    included[filled] = away < nearest_sample(color, others, SHAPE_OF_SHADES)
    return Discrimination(samples, others, np.where(included, own, 0.0)), included
