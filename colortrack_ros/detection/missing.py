"""Why a color is not found that is not in the picture, or in too little of it."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.cells import lab_of_cells
from colortrack_ros.detection.extent import SHAPE
from colortrack_ros.detection.growth import FEWEST_PIXELS
from colortrack_ros.detection.growth import NEAR
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.lab import rgb_from_lab
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.named import name_of
from colortrack_ros.detection.reference import ReferenceColor

MUCH_NEARER = 1 / 2
"""Distance of few pixels from a color over that of the nearest frequent one, up to which they are
told. Assumed: half of a small thing's pixels are mixed with what is behind."""

SMALLEST_THING = 8
"""Number of pixels from which on a thing is told of. Assumed: one 3 px wide."""


def why_missing(color: ReferenceColor, counts: NDArray[np.float64]) -> str:
    """What a picture shows in place of a color, and what to do.

    :param counts: (65536,) of :func:`sample_colors`.
    """
    name, (nearest, few) = color.name, _nearest(counts, color.lab)
    if few >= SMALLEST_THING:
        return (
            f'{name} is in {few} px of the picture, too few to find how far it extends: for things '
            f'that small set {name}.tolerance, erosion_size to 1, and a smaller min_area'
        )
    meant = '' if color.preset else name_of(color.lab)
    by_name = f', or set {name}.preset, such as {meant}' * (meant != '')
    return (
        f'{name} has not been seen yet; if it is in view, {",".join(map(str, nearest))} is nearest '
        f'(r,g,b): pick its color there, with pick_color{by_name}'
    )


def _nearest(counts: NDArray[np.float64], lab: Triple) -> tuple[tuple[int, int, int], int]:
    """The frequent color, r, g, b, nearest to a given one, and how many pixels are much nearer.

    These are 0 if none is of the color itself: then they are of another thing, which is shaded.
    """
    (filled,) = counts.nonzero()
    number, color = counts[filled], lab_of_cells(filled)
    away = nearest_sample(color, (lab,), SHAPE)
    best = np.where(number >= min(FEWEST_PIXELS, number.max()), away, np.inf).argmin()
    red, green, blue = rgb_from_lab(color[best]).tolist()
    few = number[away < MUCH_NEARER * away[best]].sum() if away.min() < NEAR else 0
    return (red, green, blue), round(few)
