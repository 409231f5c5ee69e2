"""Color extent: where in CIELAB the pixels of a color end and others begin.

Ellipsoids of one shape grow around a color. The pixels of the object come first and soon run out;
then comes a gap, and then everything else. The relative growth of the count, d ln N / d ln t, has
its valley in the gap. It is 3 if colors fill CIELAB evenly, and would be 0 in a gap but for outline
pixels: they spread all the way to the color of the surroundings, and small objects have a large
share of them.
"""

from collections.abc import Iterable
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

from colortrack_ros.detection.cells import cell_bounds
from colortrack_ros.detection.cells import CELLS
from colortrack_ros.detection.cells import cells_of
from colortrack_ros.detection.lab import rgb_from_lab
from colortrack_ros.detection.reference import Triple

# On four real clips, `python benchmark/colors.py --constants` halves and doubles the constants
# below that are neither derived nor from a source. The recall of the caps drops by 5 points with
# half of OUTLINE_WIDTH or twice HALF_WAY, and that of the ball by 2 with twice NEAR.

COUNTED_PIXELS = 1 << 19
"""Maximum number of counted pixels: all of a 640x480 picture, every second row and column of
1920x1080."""

LIGHTNESS_AXIS = 2.5
"""Initial ratio of the half axis of L to those of a and b: light and shade change L most. CIE 1994
also weights lightness less for such objects (textiles: k_L = 2)."""

SHAPE = np.array([LIGHTNESS_AXIS, 1.0, 1.0])
"""Initial half axes along L, a, b for measuring distances."""

SIZE_STEP, SLOPE_STEPS = 0.04, 5
"""Steps of the size in ln t, and the number of steps on each side for the growth, +-20 %."""

SIZES = np.exp(np.arange(np.log(4.0), np.log(80.0), SIZE_STEP))
"""Half axes of a and b to try [CIELAB units]: from the size of a cell of the table to the distance
between different colors."""

NEAR = 8.0
"""Radius within which pixels are of the color itself [CIELAB units]: a few times the just
noticeable difference, 2.3 (Mahy 1994), to allow for noise and compression."""

FEWEST_PIXELS = 20
"""Number of pixels near a color for it to be in the picture: the default of min_area."""

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

OUTLINE_WIDTH = 2.0
"""Width of an object's outline, whose pixels are mixed with the surroundings [px]: video has one
chroma sample for every 2 by 2 pixels."""

HALF_WAY = 2.0
"""Ratio of the distance of the surroundings to that of outline pixels that are half object."""

MOST_GROWTH = 1.0
"""Largest growth at the surface of an ellipsoid in a gap: a third of that of colors that fill
CIELAB evenly."""

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
    distance = (cell_bounds()[0].T - lab) / SHAPE
    return float(counts[(distance**2).sum(axis=1) < NEAR**2].sum())


def nearest_color(counts: NDArray[np.float64], lab: Triple) -> tuple[int, int, int]:
    """The frequent color, r, g, b, that is nearest to a given one."""
    (many,) = (counts >= min(FEWEST_PIXELS, counts.max())).nonzero()
    color = cell_bounds()[0].T[many]
    red, green, blue = rgb_from_lab(color[nearest_sample(color, (lab,), SHAPE).argmin()]).tolist()
    return red, green, blue


def middle_of(counts: NDArray[np.float64], extent: Extent) -> Triple | None:
    """The mean of the pixels inside an extent; None if there are too few."""
    color = cell_bounds()[0].T
    inside = (((color - extent.lab) / extent.axes) ** 2).sum(axis=1) < 1
    if counts[inside].sum() < FEWEST_PIXELS:
        return None
    L, a, b = np.average(color[inside], axis=0, weights=counts[inside]).tolist()
    return L, a, b


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
    number, color = counts[filled], cell_bounds()[0].T[filled]
    if samples or others:
        shape = SHAPE
        away = nearest_sample(color, (lab, *samples), shape)
        mine = away < nearest_sample(color, others, shape)
        alike = np.full(len(SIZES), most)
        return _valley(number[mine], away[mine], np.array(lab), shape, alike, least)
    is_gray = np.hypot(*lab[1:]) < NEAR
    most_gray = most if is_gray else min(most, max(MOST_SHADES_OF_ONE * near, allowed))
    limits = most, most_gray
    found = _deepest_valley(number, color, lab, limits, apart)
    return found or (_deepest_valley(number, color, lab, limits, ()) if apart else None)


def _deepest_valley(
    number: NDArray[np.float64],
    color: NDArray[np.float64],
    lab: Triple,
    limits: tuple[float, float],
    apart: Sequence[Triple],
) -> Extent | None:
    """Find the valley around one color; center and shape adapt to the pixels inside.

    :param limits: largest number of pixels, without gray and with gray among them.
    :param apart: colors that are left outside.
    """
    center, shape = np.array(lab), SHAPE
    best = whole = None
    for _ in range(SHAPE_ROUNDS):
        distance = nearest_sample(color, (center,), shape)
        most = np.where(np.hypot(*(center / shape)[1:]) < SIZES, limits[1], limits[0])
        if apart:
            other = nearest_sample(center[None], apart, shape)
            most[other <= SIZES] = 0.0
        found = _valley(number, distance, center, shape, most)
        if found is None or (best is not None and found.growth > best.growth - DEEPER):
            break
        best = found
        whole = _valley(number, distance, center, shape, most, to_outline=True)
        inside = (((color - center) / found.axes) ** 2).sum(axis=1) < 1
        center = np.average(color[inside], axis=0, weights=number[inside])
        variance = np.average((color[inside] - center) ** 2, axis=0, weights=number[inside])
        spread = np.maximum(np.sqrt(variance), LEAST_SPREAD)
        # Keep the volume of the initial shape.
        shape = spread * np.cbrt(LIGHTNESS_AXIS / spread.prod())
    return whole


def nearest_sample(
    color: NDArray[np.float64], samples: Iterable[ArrayLike], shape: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N,) distance to the nearest sample, infinite if there are none."""
    nearest = np.full(len(color), np.inf)
    for sample in samples:
        away = (color - np.asarray(sample, np.float64)) / shape
        np.minimum(nearest, np.sqrt((away**2).sum(axis=1)), out=nearest)
    return nearest


def growth_of(
    number: NDArray[np.float64], distance: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """How the count of pixels grows with the size, at each of SIZES but SLOPE_STEPS at both ends.

    :param number, distance: (N,) pixels of each color, and its distance.
    :returns: (S,) the relative growth, the count, and the count SLOPE_STEPS further out.
    """
    order = np.argsort(distance)
    behind = np.searchsorted(distance[order], SIZES)
    count = np.append(0.0, np.cumsum(number[order]))[behind]
    smaller, middle, larger = (
        count[: -2 * SLOPE_STEPS],
        count[SLOPE_STEPS:-SLOPE_STEPS],
        count[2 * SLOPE_STEPS :],
    )
    growth = (larger - smaller) / np.maximum(middle, 1) / (2 * SLOPE_STEPS * SIZE_STEP)
    return growth, middle, larger


def _valley(
    number: NDArray[np.float64],
    distance: NDArray[np.float64],
    center: NDArray[np.float64],
    shape: NDArray[np.float64],
    most: NDArray[np.float64],
    least: float = 0.0,
    to_outline: bool = False,
) -> Extent | None:
    """Find the size at whose surface the count grows least, for ellipsoids of one shape.

    :param most: (S,) largest number of pixels for each size.
    :param to_outline: extend it half-way to where the count grows more than an outline explains.
    """
    growth, middle, larger = growth_of(number, distance)
    growth[(middle < FEWEST_PIXELS) | (larger > most[2 * SLOPE_STEPS :])] = np.inf
    growth[SIZES[SLOPE_STEPS:-SLOPE_STEPS] < least] = np.inf
    k = int(growth.argmin())
    if not np.isfinite(growth[k]):
        return None
    outer = max(k, outline_end(growth, float(middle[k]), k)) if to_outline else k
    L, a, b = center.tolist()
    dL, da, db = (SIZES[SLOPE_STEPS + outer] * shape).tolist()
    return Extent((L, a, b), (dL, da, db), float(growth[k]), float(middle[outer]))


def outline_end(growth: NDArray[np.float64], pixels: float, valley: int) -> int:
    """The index of the size half-way to the end of a valley.

    A disc of N pixels has 2 sqrt(pi N) of them along its outline.

    :param growth: (S,) at the tested sizes.
    :param pixels: in the valley.
    :param valley: index of its size.
    """
    mixed = OUTLINE_WIDTH * 2 * np.sqrt(np.pi / pixels)
    beyond = np.append(growth[valley:] > growth[valley] + mixed, True)
    return valley + int(beyond.argmax()) - 1 - round(np.log(HALF_WAY) / SIZE_STEP)
