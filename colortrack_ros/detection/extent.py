"""Color extent: where in CIELAB the pixels of a color end and others begin.

Ellipsoids of one shape grow around a color, up to the gap between its pixels and others (see
growth.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.cells import CELLS
from colortrack_ros.detection.cells import cells_of
from colortrack_ros.detection.cells import lab_of_cells
from colortrack_ros.detection.growth import FEWEST_PIXELS
from colortrack_ros.detection.growth import growth_of
from colortrack_ros.detection.growth import MOST_GROWTH
from colortrack_ros.detection.growth import NEAR
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.growth import other_hue
from colortrack_ros.detection.growth import outline_end
from colortrack_ros.detection.growth import SIZE_STEP
from colortrack_ros.detection.growth import SIZES
from colortrack_ros.detection.growth import SLOPE_STEPS
from colortrack_ros.detection.lab import Triple

# On four real clips, `python benchmark/colors.py --constants` halves and doubles the constants
# below that are neither derived nor from a source.

COUNTED_PIXELS = 1 << 19
"""Maximum number of counted pixels: all of a 640x480 picture, every second row and column of
1920x1080."""

LIGHTNESS_AXIS = 2.5
"""Initial ratio of the half axis of L to those of a and b: light and shade change L most. CIE 1994
also weights lightness less for such objects (textiles: k_L = 2)."""

SHAPE = np.array([LIGHTNESS_AXIS, 1.0, 1.0])
"""Initial half axes along L, a, b for measuring distances."""

MOST_SHADES_OF_ONE = 30.0
"""Largest ratio of the pixels of an object with shades down to gray, to those near one of its
colors. More belong to another object, such as a black cloth beside a dark red ball. Colors of five
balls and four clips have a ratio of up to 11, that cloth of 70 to 470. With 15, as many are found;
with 60, two of 60 fewer of the dark red ball (benchmark/notes/detector.md, Shades)."""

LARGEST_SHARE = 0.25
"""Largest share of the picture that a color may cover; anything larger is background. Assumed: an
object that covers a quarter of the picture is half as wide and high."""

LARGEST_GROUND = 0.98
"""Largest share of the picture that an inverted color may cover. Assumed: all but a rim of half a
percent of its width."""

LEAST_SPREAD = 2.0
"""Least standard deviation of an object along an axis [CIELAB units]: the size of a cell of the
table."""

SHAPE_ROUNDS, DEEPER = 4, 0.02
"""Maximum number of updates of center and shape from the pixels inside, and the least decrease of
the growth for another one. Assumed: they bound the time."""


@dataclass(frozen=True)
class Extent:
    """The ellipsoid in CIELAB that contains the pixels of a color.

    :param lab: its center.
    :param axes: its half axes along L, a, b.
    :param growth: least growth of the count inside its surface, d ln N / d ln t; any growth beyond
        is due to the outline, evenly on all sides.
    :param pixels: number of pixels inside.
    """

    lab: Triple
    axes: Triple
    growth: float
    pixels: float


def sample_colors(
    picture: NDArray[np.uint8], encoding: str
) -> tuple[NDArray[np.uint16], NDArray[np.float64]]:
    """The color table cells of a picture, and their histogram.

    :return: (H, W) the cells of at most COUNTED_PIXELS pixels, on a regular grid, and (65536,) the
        number of the picture's pixels in each cell.
    """
    pixels = picture.shape[0] * picture.shape[1]
    step = int(np.ceil(np.sqrt(pixels / COUNTED_PIXELS)))
    cells = cells_of(np.ascontiguousarray(picture[::step, ::step]), encoding)
    counts = np.bincount(cells.reshape(-1), minlength=CELLS).astype(np.float64)
    return cells, counts * round(pixels / cells.size)


def count_colors(picture: NDArray[np.uint8], encoding: str) -> NDArray[np.float64]:
    """(65536,) number of pixels in each cell of the color table."""
    return sample_colors(picture, encoding)[1]


def pixels_near(counts: NDArray[np.float64], lab: Triple) -> float:
    """Number of pixels near a color."""
    (filled,) = counts.nonzero()
    distance = (lab_of_cells(filled) - lab) / SHAPE
    return float(counts[filled[(distance**2).sum(axis=1) < NEAR**2]].sum())


def measure(counts: NDArray[np.float64], extent: Extent) -> Extent:
    """An extent with the mean, the growth, and the number of the pixels inside it in a picture."""
    (filled,) = counts.nonzero()
    number, color = counts[filled], lab_of_cells(filled)
    squared = (((color - extent.lab) / extent.axes) ** 2).sum(axis=1)
    reach = 2 * SLOPE_STEPS * SIZE_STEP  # from the smaller to the larger size, in ln t
    inner, inside, outer = (squared < size for size in np.exp([-reach, 0, reach]))
    smaller, pixels, larger = (float(number[each].sum()) for each in (inner, inside, outer))
    if not pixels:
        return replace(extent, growth=0.0, pixels=0.0)
    L, a, b = (number[inside] @ color[inside] / pixels).tolist()
    growth = (larger - smaller) / pixels / reach
    return replace(extent, lab=(L, a, b), growth=growth, pixels=pixels)


def find_extent(
    counts: NDArray[np.float64],
    lab: Triple,
    samples: tuple[Triple, ...] = (),
    others: tuple[Triple, ...] = (),
    largest_share: float = LARGEST_SHARE,
    least: float = 0.0,
    allowed: float = 0.0,
    apart: Sequence[Triple] = (),
) -> Extent | None:
    """Find the extent of a color from the deepest valley around it.

    :param counts: (65536,) of :func:`count_colors`.
    :param lab: the color, or one within it.
    :param samples, others: of the color; they keep its center and the initial shape fixed.
    :param largest_share: largest share of the picture that it may cover.
    :param least: least half axis of a and b, with samples or others.
    :param allowed: number of pixels that it may have, even gray ones, although few are near it: for
        a known object whose light has changed.
    :param apart: colors that other objects have, which are left outside if possible.
    :returns: None if it is not in the picture, or no size of it stays below that share.
    """
    near = max(pixels_near(counts, sample) for sample in (lab, *samples))
    if near < FEWEST_PIXELS:
        return None
    most = largest_share * counts.sum()
    (filled,) = (counts > 0).nonzero()
    number, color = counts[filled], lab_of_cells(filled)
    if samples or others:
        away = nearest_sample(color, (lab, *samples), SHAPE)
        mine, alike = away < nearest_sample(color, others, SHAPE), np.full(len(SIZES), most)
        growth, count = _growth_within(number[mine], away[mine], alike, least)
        both = _valley(growth, count, np.array(lab), SHAPE)
        return both and both[0]
    is_gray = np.hypot(*lab[1:]) < NEAR
    most_gray = most if is_gray else min(most, max(MOST_SHADES_OF_ONE * near, allowed))
    limits = most, most_gray
    found = _ValleySearch(number, color, limits, apart).deepest(lab)
    return found or (_ValleySearch(number, color, limits, ()).deepest(lab) if apart else None)


@dataclass(frozen=True)
class _ValleySearch:
    """A search for the valley around one color.

    :param number, color: (N,), (N, 3) pixels of each color.
    :param limits: largest number of pixels, without gray and with gray among them.
    :param apart: colors that are left outside.
    """

    number: NDArray[np.float64]
    color: NDArray[np.float64]
    limits: tuple[float, float]
    apart: Sequence[Triple]

    def deepest(self, lab: Triple) -> Extent | None:
        """The extent that ends in the deepest valley.

        The shape is none of the color's own at first, so that valleys hardly differ in depth, and
        noise decides which is the deepest. So each up to there is tried, and its depth compared
        when center and shape have adapted to the pixels inside.
        """
        center = np.array(lab)
        growth, count = self._growth(center, SHAPE)
        found = [
            self._adapted(_reaching(valley, growth, count, center, SHAPE))
            for valley in _valleys(growth)
        ]
        return min(found, key=lambda both: both[0].growth)[1] if found else None

    def _adapted(self, found: tuple[Extent, Extent]) -> tuple[Extent, Extent]:
        """An extent of :func:`_valley` with center and shape of its pixels while that is deeper."""
        for _ in range(SHAPE_ROUNDS - 1):
            best, color, number = found[0], self.color, self.number
            inside = (((color - best.lab) / best.axes) ** 2).sum(axis=1) < 1
            center = np.average(color[inside], axis=0, weights=number[inside])
            variance = np.average((color[inside] - center) ** 2, axis=0, weights=number[inside])
            spread = np.maximum(np.sqrt(variance), LEAST_SPREAD)
            # Keep the volume of the initial shape.
            shape = spread * np.cbrt(LIGHTNESS_AXIS / spread.prod())
            both = _valley(*self._growth(center, shape), center, shape)
            if both is None or both[0].growth > best.growth - DEEPER:
                break
            found = both
        return found

    def _growth(
        self, center: NDArray[np.float64], shape: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The growth around a center up to colors of another hue, and the count, both (S,)."""
        number, color, limits = self.number, self.color, self.limits
        distance = nearest_sample(color, (center,), shape)
        most = np.where(np.hypot(*(center / shape)[1:]) < SIZES, limits[1], limits[0])
        if self.apart:
            other = nearest_sample(center[None], self.apart, shape)
            most[other <= SIZES] = 0.0
        growth, count = _growth_within(number, distance, most)
        end = other_hue(growth, number, color, distance, center)
        growth = growth[:end]
        within = SIZES[SLOPE_STEPS : SLOPE_STEPS + end] < NEAR
        if (growth[~within] < MOST_GROWTH).any():  # as in other_hue, a gap within the color itself
            growth[within] = np.inf
        return growth, count


def _valleys(growth: NDArray[np.float64]) -> list[int]:
    """The valleys up to the deepest: what has no less growth among the sizes that it counts."""
    deepest = int(growth.argmin())
    lowest = cv2.erode(growth[None], np.ones((1, 4 * SLOPE_STEPS + 1)))[0]
    is_one = np.isfinite(growth) & (growth == lowest)
    return np.flatnonzero(is_one[: deepest + 1]).tolist()


def _growth_within(
    number: NDArray[np.float64],
    distance: NDArray[np.float64],
    most: NDArray[np.float64],
    least: float = 0.0,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The growth at each size, infinite where it cannot be the color's, and the count, both (S,).

    :param number, distance: (N,) pixels of each color, and its distance.
    :param most: largest number of pixels for each of SIZES.
    :param least: least size.
    """
    growth, count, larger = growth_of(number, distance)
    growth[(count < FEWEST_PIXELS) | (larger > most[2 * SLOPE_STEPS :])] = np.inf
    growth[SIZES[SLOPE_STEPS:-SLOPE_STEPS] < least] = np.inf
    return growth, count


def _valley(
    growth: NDArray[np.float64],
    count: NDArray[np.float64],
    center: NDArray[np.float64],
    shape: NDArray[np.float64],
) -> tuple[Extent, Extent] | None:
    """What :func:`_reaching` the deepest valley is; None if no size can be the color's."""
    valley = int(growth.argmin())
    return _reaching(valley, growth, count, center, shape) if np.isfinite(growth[valley]) else None


def _reaching(
    valley: int,
    growth: NDArray[np.float64],
    count: NDArray[np.float64],
    center: NDArray[np.float64],
    shape: NDArray[np.float64],
) -> tuple[Extent, Extent]:
    """The extent that ends in a valley, and one that holds the outline as well.

    The latter reaches half-way to where the count grows more than an outline explains.

    :param valley: index of its size.
    """
    outer = max(valley, outline_end(growth, float(count[valley]), valley))

    def reaching(k: int) -> Extent:
        (L, a, b), (dL, da, db) = center.tolist(), (SIZES[SLOPE_STEPS + k] * shape).tolist()
        return Extent((L, a, b), (dL, da, db), float(growth[valley]), float(count[k]))

    return reaching(valley), reaching(outer)
