"""How far a color reaches in a picture: where its own pixels end and others begin.

Counted outwards from a color, in ellipsoids of one shape, the pixels of a thing come first and soon
run out; then comes a gap, and then everything else. The relative growth of the count,
d ln N / d ln t, has its valley there. It is 3 where colors fill CIELAB evenly, and 0 in a gap, but
for the pixels of outlines: they lie all the way to the color of what is around, and a thing of few
pixels has many of them.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

from colortrack_ros.detection.cells import cell_bounds
from colortrack_ros.detection.cells import CELLS
from colortrack_ros.detection.cells import cells_of
from colortrack_ros.detection.lab import rgb_from_lab
from colortrack_ros.detection.reference import Triple

# On four real clips, `python benchmark/colors.py --constants` halves and doubles those below that
# are neither derived nor from a source: recall of the caps falls by 5 points with half of
# OUTLINE_WIDTH or twice HALF_WAY, and that of the ball by 2 with twice NEAR.

COUNTED_PIXELS = 1 << 19
"""Pixels of a picture that are counted at most: 640x480 as it is, every second row and column of
1920x1080."""

LIGHTNESS_AXIS = 2.5
"""Half axis of L over those of a and b at first: light and shade move L most. CIE 1994 weighs
lightness less for such things, too (textiles: k_L = 2)."""

SHAPE = np.array([LIGHTNESS_AXIS, 1.0, 1.0])
"""Half axes along L, a, b that distances are measured with at first."""

SIZE_STEP, SLOPE_STEPS = 0.04, 5
"""Steps of the size in ln t, and how many the growth is taken over to each side, +-20 %."""

END_SHIFT = 0.02
"""Shift of a centroid along one axis by not knowing where a color ends (standard deviation) [shares
of the width of its blur]: sizes that are 20 % larger and smaller, what a valley is known to, shift
those of `single`, `five`, `juggle`, and `clutter` by 0.015 to 0.03."""

SIZES = np.exp(np.arange(np.log(4.0), np.log(80.0), SIZE_STEP))
"""Half axes of a and b that are tried [CIELAB units]: from the size of a cell of the table to the
distance of different colors."""

NEAR = 8.0
"""Where pixels of the color itself are looked for [CIELAB units]: a few times what is just seen as
different, 2.3 (Mahy 1994), for noise and compression."""

FEWEST_PIXELS = 20
"""Pixels that a color must have near it to be in the picture: the default of min_area."""

MOST_SHADES_OF_ONE = 30.0
"""Pixels of a thing that has shades down to gray, at most, over those that have one of its colors:
more are another thing, such as a black cloth beside a dark red ball. Colors of five balls and four
clips have up to 11 times as many, that cloth 70 to 470 times. With 15 as many are found; with 60,
two of 60 fewer of the dark red ball (benchmark/notes/detector.md, Shades)."""

LARGEST_SHARE = 0.25
"""Share of the picture that a color may cover; what is larger is its background."""

LARGEST_GROUND = 0.98
"""Share of the picture that a color may cover of which everything else is looked for."""

LEAST_SPREAD = 2.0
"""Least standard deviation of a thing along an axis [CIELAB units]: that of a cell of the table."""

OUTLINE_WIDTH = 2.0
"""Width of the outline of a thing, whose pixels are mixed with what is around [px]: video has a
color for every 2 by 2 pixels."""

HALF_WAY = 2.0
"""Ratio of the distance of what is around to that of the outline, where a pixel is half of it."""

MOST_GROWTH = 1.0
"""Growth at the surface of an ellipsoid that is still a gap: a third of that of colors that fill
CIELAB evenly."""

SHAPE_ROUNDS, DEEPER = 4, 0.02
"""How often center and shape follow what is inside, as long as the valley gets deeper by this."""


@dataclass(frozen=True)
class Extent:
    """The ellipsoid in CIELAB that holds the pixels of a color.

    :param lab: its center.
    :param axes: its half axes along L, a, b.
    :param growth: least of the count on the way to its surface, d ln N / d ln t: what grows more
        there is the outline, evenly on all sides.
    :param pixels: within it.
    """

    lab: Triple
    axes: Triple
    growth: float
    pixels: float


def sample_colors(
    picture: NDArray[np.uint8], encoding: str
) -> tuple[NDArray[np.uint16], NDArray[np.float64]]:
    """Where the colors of a picture are in the color table, and how often.

    :return: (H, W) the cells of at most COUNTED_PIXELS of it, every so many rows and columns, and
        (65536,) pixels of the picture in each cell.
    """
    pixels = picture.shape[0] * picture.shape[1]
    step = int(np.ceil(np.sqrt(pixels / COUNTED_PIXELS)))
    cells = cells_of(np.ascontiguousarray(picture[::step, ::step]), encoding)
    counts = np.bincount(cells.reshape(-1), minlength=CELLS).astype(np.float64)
    return cells, counts * round(pixels / cells.size)


def count_colors(picture: NDArray[np.uint8], encoding: str) -> NDArray[np.float64]:
    """(65536,) pixels of the picture in each cell of the color table."""
    return sample_colors(picture, encoding)[1]


def pixels_near(counts: NDArray[np.float64], lab: Triple) -> float:
    """How many pixels there are of a color itself."""
    distance = (cell_bounds()[0].T - lab) / SHAPE
    return float(counts[(distance**2).sum(axis=1) < NEAR**2].sum())


def nearest_color(counts: NDArray[np.float64], lab: Triple) -> tuple[int, int, int]:
    """The color r, g, b that is nearest to one, of those that many pixels have."""
    (many,) = (counts >= min(FEWEST_PIXELS, counts.max())).nonzero()
    color = cell_bounds()[0].T[many]
    red, green, blue = rgb_from_lab(color[nearest_sample(color, (lab,), SHAPE).argmin()]).tolist()
    return red, green, blue


def middle_of(counts: NDArray[np.float64], extent: Extent) -> Triple | None:
    """The mean of the pixels within an extent; None when there are too few."""
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
) -> Extent | None:
    """The pixels that belong to a color, by the deepest valley around it.

    :param counts: (65536,) of :func:`count_colors`.
    :param lab: the color, or one within it.
    :param samples, others: of the color; with them it stays where it is, and has the first shape.
    :param largest_share: of the picture, that it may cover.
    :param least: half axis of a and b that it has at least, with samples or others.
    :param allowed: pixels that it may have, gray ones too, even if few are near it: where the
        light on a known thing has changed.
    :returns: None when it is not in the picture, or no size of it stays below that share.
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
    return _deepest_valley(number, color, lab, (most, most_gray))


def _deepest_valley(
    number: NDArray[np.float64],
    color: NDArray[np.float64],
    lab: Triple,
    limits: tuple[float, float],
) -> Extent | None:
    """The valley around one color, whose center and shape follow what is inside.

    :param limits: pixels that it may have, and with gray among them.
    """
    center, shape = np.array(lab), SHAPE
    best = whole = None
    for _ in range(SHAPE_ROUNDS):
        distance = nearest_sample(color, (center,), shape)
        most = np.where(np.hypot(*(center / shape)[1:]) < SIZES, limits[1], limits[0])
        found = _valley(number, distance, center, shape, most)
        if found is None or (best is not None and found.growth > best.growth - DEEPER):
            break
        best = found
        whole = _valley(number, distance, center, shape, most, to_outline=True)
        inside = (((color - center) / found.axes) ** 2).sum(axis=1) < 1
        center = np.average(color[inside], axis=0, weights=number[inside])
        variance = np.average((color[inside] - center) ** 2, axis=0, weights=number[inside])
        spread = np.maximum(np.sqrt(variance), LEAST_SPREAD)
        # Of the volume that the first shape has.
        shape = spread * np.cbrt(LIGHTNESS_AXIS / spread.prod())
    return whole


def nearest_sample(
    color: NDArray[np.float64], samples: Iterable[ArrayLike], shape: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N,) distance to the nearest sample, infinite where there is none."""
    nearest = np.full(len(color), np.inf)
    for sample in samples:
        away = (color - np.asarray(sample, np.float64)) / shape
        np.minimum(nearest, np.sqrt((away**2).sum(axis=1)), out=nearest)
    return nearest


def _valley(
    number: NDArray[np.float64],
    distance: NDArray[np.float64],
    center: NDArray[np.float64],
    shape: NDArray[np.float64],
    most: NDArray[np.float64],
    least: float = 0.0,
    to_outline: bool = False,
) -> Extent | None:
    """The size at whose surface the count grows least, of ellipsoids of a shape around a center.

    :param most: (S,) pixels that each size may have.
    :param to_outline: or the larger one half-way to where it grows more than by an outline.
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
    growth[(middle < FEWEST_PIXELS) | (larger > most[2 * SLOPE_STEPS :])] = np.inf
    growth[SIZES[SLOPE_STEPS:-SLOPE_STEPS] < least] = np.inf
    k = int(growth.argmin())
    if not np.isfinite(growth[k]):
        return None
    outer = max(k, _outline(growth, float(middle[k]), k)) if to_outline else k
    L, a, b = center.tolist()
    dL, da, db = (SIZES[SLOPE_STEPS + outer] * shape).tolist()
    return Extent((L, a, b), (dL, da, db), float(growth[k]), float(middle[outer]))


def _outline(growth: NDArray[np.float64], pixels: float, valley: int) -> int:
    """The index of the size half-way to the end of a valley.

    A disc of N pixels has 2 sqrt(pi N) of them along its outline.

    :param growth: (S,) at the sizes that are tried.
    :param pixels: in the valley.
    :param valley: index of its size.
    """
    mixed = OUTLINE_WIDTH * 2 * np.sqrt(np.pi / pixels)
    beyond = np.append(growth[valley:] > growth[valley] + mixed, True)
    return valley + int(beyond.argmax()) - 1 - round(np.log(HALF_WAY) / SIZE_STEP)
