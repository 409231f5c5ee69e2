"""Colors by name: which of all that a name such as red stands for a picture shows."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.cells import cell_bounds
from colortrack_ros.detection.extent import SHAPE
from colortrack_ros.detection.growth import FEWEST_PIXELS
from colortrack_ros.detection.growth import NEAR
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.presets import PRESETS
from colortrack_ros.detection.reference import ReferenceColor

MOST_CANDIDATES = 64
"""Most cells of the table that are compared. Assumed: those that weigh most of a picture's hundreds
of a name are of all its things."""


def as_named(
    color: ReferenceColor, counts: NDArray[np.float64], taken: Sequence[ReferenceColor] = ()
) -> tuple[ReferenceColor, float]:
    """A color given by its name as a picture shows it, and how far that is from what is meant.

    :param counts, taken: as for :func:`color_by_name`.
    :returns: itself if it is not given by its name, with 0, or if nothing shows it, with 1.
    """
    if not color.preset:
        return color, 0.0
    if (shown := color_by_name(counts, color.preset, taken)) is None:
        return color, 1.0
    typical, axes = PRESETS[color.preset]
    away = nearest_sample(np.array([shown]), (typical,), np.array(axes))
    return replace(color, lab=shown), float(away[0])


def color_by_name(
    counts: NDArray[np.float64], preset: str, taken: Sequence[ReferenceColor] = ()
) -> Triple | None:
    """The color, in CIELAB, of which a picture shows most among those that a name stands for.

    A pixel weighs 1 if its color is just what is meant, and 0 at the surface of the ellipsoid of
    what may be: wood is a red of few words, and there is much of it.

    :param counts: (65536,) number of pixels in each cell of the color table.
    :param preset: a key of PRESETS.
    :param taken: other colors, as far as they extend: what is theirs, or near it, as their shades
        are, is none of this name.
    :returns: None if there are fewer than FEWEST_PIXELS.
    """
    typical, axes = PRESETS[preset]
    (filled,) = counts.nonzero()
    color = cell_bounds()[0].T[filled]
    away = nearest_sample(color, (typical,), np.array(axes))
    is_named = away < 1
    number, color, weight = counts[filled[is_named]], color[is_named], 1 - away[is_named] ** 2
    for other in taken:
        if not other.inverted:
            colors, reach = (other.lab, *other.samples), np.array(other.axes) + NEAR * SHAPE
            is_free = nearest_sample(color, colors, reach) >= 1
            number, color, weight = number[is_free], color[is_free], weight[is_free]
    if number.sum() < FEWEST_PIXELS:
        return None
    best = np.argsort(-number * weight)[:MOST_CANDIDATES]
    is_near = np.linalg.norm((color[best, None] - color) / SHAPE, axis=2) < NEAR
    near = is_near @ number
    L, a, b = color[best[np.argmax(near * weight[best])]].tolist()
    return (L, a, b) if near.max() >= FEWEST_PIXELS else None
