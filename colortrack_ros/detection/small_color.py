"""The extent of a color of which the picture has too few pixels for a gap around it to be seen."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.cells import lab_of_cells
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.extent import LARGEST_SHARE
from colortrack_ros.detection.extent import SHAPE
from colortrack_ros.detection.growth import FEWEST_PIXELS
from colortrack_ros.detection.growth import HALF_WAY
from colortrack_ros.detection.growth import NEAR
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.named import MOST_CANDIDATES
from colortrack_ros.detection.named import typical_of
from colortrack_ros.detection.reference import ReferenceColor

REACH_ALIKE = 0.2
"""Relative change of the reach up to which an extent is kept as it is. Assumed: it spares a color
table at every look, and moves the outline of a small thing by a tenth of a pixel."""


def small_extent(
    counts: NDArray[np.float64],
    color: ReferenceColor,
    apart: Sequence[Triple],
    known: Extent | None,
) -> Extent | None:
    """Half-way from a color to the nearest one of which there are many pixels.

    There, a pixel of an outline is half of either. Whatever is frequent bounds it, not only what is
    around the things: noise that has a color in single pixels has more of the colors before it.

    :param counts: (65536,) of :func:`sample_colors`, pooled.
    :param apart: colors that other objects have.
    :param known: the extent before, which is kept if the new one is alike.
    :returns: None if the color is not in the picture, fills it, or is not told from what is
        frequent.
    """
    (filled,) = counts.nonzero()
    number, labs = counts[filled], lab_of_cells(filled)
    lab = _shown(number, labs, color.preset) if color.preset else color.lab
    if lab is None:
        return None
    away = nearest_sample(labs, (lab,), SHAPE)
    others = away[(number >= FEWEST_PIXELS) & (away > NEAR)]
    others = np.concatenate([others, nearest_sample(np.array([lab]), apart, SHAPE)])
    reach = float(others.min()) / HALF_WAY
    if away.min() >= NEAR or not NEAR <= reach < np.inf:
        return None
    pixels = float(number[away < reach].sum())
    if pixels > LARGEST_SHARE * number.sum():
        return None
    if (
        known
        and abs(reach * SHAPE[1] / known.axes[1] - 1) < REACH_ALIKE
        and _is_near(lab, known.lab)
    ):
        return known
    dL, da, db = (reach * SHAPE).tolist()
    return Extent(lab, (dL, da, db), 0.0, pixels)


def _is_near(one: Triple, other: Triple) -> bool:
    """Whether two colors are one."""
    return bool(nearest_sample(np.array([one]), (other,), SHAPE)[0] < NEAR)


def _shown(number: NDArray[np.float64], labs: NDArray[np.float64], preset: str) -> Triple | None:
    """The color typical of a name of which there is most; None if there is none.

    :param number, labs: (N,), (N, 3) of each color.
    """
    weight = number * typical_of(labs, preset)[0]
    best = np.argsort(-weight)[:MOST_CANDIDATES]
    best = best[weight[best] > 0]
    if not len(best):
        return None
    away = np.linalg.norm((labs[best, None] - labs[best]) / SHAPE, axis=2)
    L, a, b = labs[best[((away < NEAR) @ weight[best]).argmax()]].tolist()
    return L, a, b
