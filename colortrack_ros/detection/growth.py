"""Growth: how the pixels of a color become more as the ellipsoid around it grows.

The pixels of the object come first and soon run out; then comes a gap, and then everything else.
The relative growth of the count, d ln N / d ln t, has its valley in the gap. It is 3 if colors fill
CIELAB evenly, and would be 0 in a gap but for outline pixels: they spread all the way to the color
of the surroundings, and small objects have a large share of them.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

# On four real clips, `python benchmark/colors.py --constants` halves and doubles the constants
# below that are neither derived nor from a source. The recall of the caps drops by 5 points with
# half of OUTLINE_WIDTH or twice HALF_WAY, and that of the ball by 2 with twice NEAR.

SIZE_STEP, SLOPE_STEPS = 0.04, 5
"""Steps of the size in ln t, and the number of steps on each side for the growth, +-20 %."""

SIZES = np.exp(np.arange(np.log(4.0), np.log(80.0), SIZE_STEP))
"""Half axes of a and b to try [CIELAB units]: from the size of a cell of the table to the distance
between different colors."""

FEWEST_PIXELS = 20
"""Number of pixels near a color for it to be in the picture: the default of min_area."""

OUTLINE_WIDTH = 2.0
"""Width of an object's outline, whose pixels are mixed with the surroundings [px]: video has one
chroma sample for every 2 by 2 pixels."""

HALF_WAY = 2.0
"""Ratio of the distance of the surroundings to that of outline pixels that are half object."""

MOST_GROWTH = 1.0
"""Largest growth at the surface of an ellipsoid in a gap: a third of that of colors that fill
CIELAB evenly."""

NEAR = 8.0
"""Radius within which pixels are of the color itself [CIELAB units]: a few times the just
noticeable difference, 2.3 (Mahy 1994), to allow for noise and compression."""

RISEN = 1.5
"""Growth from which on colors beyond a gap are a new group: half of that of colors that fill
CIELAB evenly. `python benchmark/one_pixel.py`, wheels: 180 of 192 pixels are right; 180 with 1.2,
168 with 2, 145 without."""

OFF_LINE = 0.5
"""Distance from the line of a color's shades, over that along it, from which colors are of another
hue: 27 degrees. There 180 are right with half of it, 177 with twice as much."""

NO_LIGHT = np.array([-16.0, 0.0, 0.0])
"""Point where the shades of all matte colors would meet: less light scales X, Y, Z alike, and L +
16, a, and b, and distances between colors, are proportional to their cube root (CIE 15:2004)."""


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


def other_hue(
    growth: NDArray[np.float64],
    number: NDArray[np.float64],
    color: NDArray[np.float64],
    distance: NDArray[np.float64],
    center: NDArray[np.float64],
) -> int:
    """The index of the size at which, beyond a gap, colors of another hue come in.

    They are another object's: the shades of one lie on a line through :data:`NO_LIGHT`.

    :param growth: (S,) of :func:`growth_of`, infinite where a size cannot be the color's.
    :param number, color, distance: (N,), (N, 3), (N,) pixels of each color, and its distance.
    :param center: (3,) of the color.
    :returns: S if there are none.
    """
    line = (center - NO_LIGHT) / np.linalg.norm(center - NO_LIGHT)
    least, gap = MOST_GROWTH, -1
    rises = np.append(growth[1:] > growth[:-1], False)
    for k, rate in enumerate(growth.tolist()):
        if rate < least:
            least, gap = rate, k
        elif gap >= 0 and rate > RISEN:
            peak = k + int((~rises[k:]).argmax())
            inner, outer = SIZES[[gap + SLOPE_STEPS, peak + SLOPE_STEPS]]
            if inner < NEAR:  # a gap within the color itself, as few different colors have
                continue
            new = (inner < distance) & (distance <= outer)
            away = number[new] @ (color[new] - center)
            along = away @ line
            if np.linalg.norm(away - along * line) > OFF_LINE * abs(along):
                return k
    return len(growth)


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
