"""Colors by name: which of all that a name such as red stands for a picture shows.

A name is first of all that of what is typically called so, and failing that of any color of its
hues: the green of a dull ball is found where nothing is greener. Of several colors, the one of
which there is most in things is meant, not that of a ground, or of specks.
"""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.cells import lab_of_cells
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.extent import pixels_near
from colortrack_ros.detection.extent import SHAPE
from colortrack_ros.detection.growth import FEWEST_PIXELS
from colortrack_ros.detection.growth import MOST_GROWTH
from colortrack_ros.detection.growth import NEAR
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.growth import RISEN
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.morphology import EROSION
from colortrack_ros.detection.presets import HUES
from colortrack_ros.detection.presets import PRESETS
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.strangers import label_extent

MOST_CANDIDATES = 64
"""Most cells of the table that are compared. Assumed: those that weigh most of a picture's hundreds
of a name are of all its things."""

MOST_TRIED = 3
"""Most colors that are tried of those that are typical of a name, and of the others. Assumed: the
first is right, but for a ground and its shadow."""

LEAST_CHROMA = 13.0
"""Least distance from gray of what has a name [CIELAB units]: that of the palest color of CSS with
a name here, lightsteelblue, 15.4, less half of a cell of the color table."""

NATURAL_HUES, NATURAL_CHROMA = (20.0, 110.0), 55.0
"""Hues [degrees] and chromas [CIELAB units] of skin, wood, sand, and walls in warm light: nobody
who asks for orange means these."""

LARGEST_DULL_SHARE = 0.1
"""Largest share of the picture of what is not typical of its name: walls, paper, and the sky are of
some hue, too. Assumed."""

OF_OTHERS = 'pink', 'purple'
"""Names of which more vivid colors have another: red or magenta, and blue, of which the most vivid
has the hue of purple in CIELAB."""

TYPICAL, ALL_OF_ITS_HUES = 1, 2
"""How far a name may reach."""

LEAST_CORE = 1 / 3
"""Least share of the pixels of things that are none of their outlines: a disc of FEWEST_PIXELS has
a radius of 2.5 px, and (1.5 / 2.5)^2 of its pixels are further than one from the outside."""


@dataclass(frozen=True)
class Choice:
    """A color that a picture shows by a name.

    :param lab: the color, in CIELAB.
    :param misfit: how far it is from what the name is typical of: below 1 if it is typically called
        so, and below 2 if it has one of its hues.
    :param extent: how far it extends; None if it is a ground, more than the color may cover.
    :param is_sound: whether there is a gap around it, its pixels form things, and their mean is no
        gray: black with a red tinge here and there is not red.
    """

    lab: Triple
    misfit: float
    extent: Extent | None
    is_sound: bool

    @property
    def rank(self) -> int:
        """The larger, the more likely it is what is meant."""
        return (1 + (self.misfit < 1)) * self.is_sound


def choose(
    cells: NDArray[np.uint16],
    counts: NDArray[np.float64],
    color: ReferenceColor,
    taken: Sequence[ReferenceColor],
    find: Callable[[Triple], Extent | None],
    *,
    reach: int = ALL_OF_ITS_HUES,
) -> Choice | None:
    """The color that a picture shows by the name of another.

    :param cells, counts: (H, W) and (65536,) of :func:`sample_colors`.
    :param taken: as for :func:`candidates`.
    :param find: finds how far a color extends.
    :param reach: TYPICAL for only what is typically called so.
    :returns: of the first rank that there is, what there is most of; None if nothing has the name.
    """

    def tried(lab: Triple, misfit: float) -> Choice:
        return assess(cells, counts, color, lab, misfit, find(lab))

    best = None
    for lab, misfit in candidates(counts, color.preset, taken, reach=reach):
        choice = tried(lab, misfit)
        if choice.extent and choice.rank:  # the middle of its colors stands for it rather
            middle = tried(choice.extent.lab, misfit)
            is_more = pixels_near(counts, middle.lab) > pixels_near(counts, lab)
            return middle if is_more and middle.rank == choice.rank else choice
        if misfit < 1 and (best is None or best.extent is None):
            best = choice
    return best


def assess(
    cells: NDArray[np.uint16],
    counts: NDArray[np.float64],
    color: ReferenceColor,
    lab: Triple,
    misfit: float,
    extent: Extent | None,
) -> Choice:
    """A candidate for a color by its name, with whether it is sound; all but a ground is."""
    if color.inverted or extent is None:
        return Choice(lab, misfit, extent, extent is not None)
    label = np.minimum(label_extent(cells, counts, lab, extent), 1)
    core = np.count_nonzero(cv2.erode(label, EROSION))
    is_thing = core > LEAST_CORE * np.count_nonzero(label)
    if misfit < 1:
        return Choice(lab, misfit, extent, bool(extent.growth < RISEN and is_thing))
    is_small = extent.pixels < LARGEST_DULL_SHARE * counts.sum()
    is_colored = np.hypot(*extent.lab[1:]) > LEAST_CHROMA
    is_one = extent.growth < MOST_GROWTH and is_small and is_colored and is_thing
    return Choice(lab, misfit, extent, bool(is_one))


def candidates(
    counts: NDArray[np.float64],
    preset: str,
    taken: Sequence[ReferenceColor] = (),
    *,
    reach: int = ALL_OF_ITS_HUES,
) -> Iterator[tuple[Triple, float]]:
    """The colors, in CIELAB, that a picture shows by a name, and how far each is from typical.

    What is typically called so comes first, then the other colors of its hues; of each, what there
    is most of. A pixel weighs 1 if its color is just what is meant, and 0 at the surface of the
    ellipsoid of what may be: wood is a red of few words, and there is much of it.

    :param counts: (65536,) number of pixels in each cell of the color table.
    :param preset: a key of PRESETS.
    :param taken: other colors, as far as they extend: what is theirs, or near it, as their shades
        are, is none of this name.
    :param reach: as for :func:`choose`.
    """
    (filled,) = counts.nonzero()
    color, number = lab_of_cells(filled), counts[filled]
    for weigh in (typical_of, _of_its_hues)[:reach]:
        weight, misfit = weigh(color, preset)
        is_one = weight > 0
        is_one[is_one] = are_free(color[is_one], taken)
        of_name = number[is_one], color[is_one], weight[is_one]
        for k in _most_of(*of_name):
            L, a, b = of_name[1][k].tolist()
            yield (L, a, b), float(misfit[is_one][k])


def are_free(color: NDArray[np.float64], taken: Sequence[ReferenceColor]) -> NDArray[np.bool_]:
    """(N,) whether colors, (N, 3), are none of others, nor near them; as for candidates()."""
    free = np.ones(len(color), bool)
    for other in taken:
        if not other.inverted and free.any():
            colors, axes = (other.lab, *other.samples), np.array(other.axes) + NEAR * SHAPE
            free[free] = nearest_sample(color[free], colors, axes) >= 1
    return free


def _most_of(
    number: NDArray[np.float64], color: NDArray[np.float64], weight: NDArray[np.float64]
) -> list[int]:
    """The colors of which there is most, none near another, at most MOST_TRIED.

    :param number, color, weight: (N,), (N, 3), (N,) of each color.
    """
    if number.sum() < FEWEST_PIXELS:
        return []
    best = np.argsort(-number * weight)[:MOST_CANDIDATES]
    away = np.sqrt(sum(((c[best, None] - c) / s) ** 2 for c, s in zip(color.T, SHAPE, strict=True)))
    near = (away < NEAR) @ number
    worth = np.where(near < FEWEST_PIXELS, 0, near * weight[best])
    most = list[int]()
    while worth.any() and len(most) < MOST_TRIED:
        most.append(int(best[worth.argmax()]))
        worth[away[worth.argmax(), best] < 2 * NEAR] = 0
    return most


def typical_of(color: NDArray[np.float64], preset: str) -> tuple[NDArray[np.float64], ...]:
    """(N,) weight and misfit of colors, (N, 3), by how typical of a name they are.

    Nothing is too vivid for its name, but for those of OF_OTHERS: what is more so than typical is
    taken for what is just as vivid, of the same hue.
    """
    typical, axes = PRESETS[preset]
    if preset in HUES and preset not in OF_OTHERS:
        color = np.array(color)
        most = np.hypot(*typical[1:])
        color[:, 1:] *= most / np.maximum(most, np.hypot(*color[:, 1:].T))[:, None]
    misfit = nearest_sample(color, (typical,), np.array(axes))
    return np.maximum(1 - misfit**2, 0), misfit


def _of_its_hues(color: NDArray[np.float64], preset: str) -> tuple[NDArray[np.float64], ...]:
    """(N,) weight and misfit of colors, (N, 3), of the hues of a name, by how vivid they are."""
    (low, high), (dark, light) = HUES.get(preset, ((0.0, 0.0), (0.0, 0.0)))
    L, a, b = color.T
    chroma, hue = np.hypot(a, b), np.degrees(np.arctan2(b, a))
    is_natural = (NATURAL_HUES[0] < hue) & (hue < NATURAL_HUES[1]) & (chroma < NATURAL_CHROMA)
    is_one = ((hue - low) % 360 < high - low) & (dark < L) & (light > L) & ~is_natural
    weight = np.where(is_one & (chroma > LEAST_CHROMA), chroma / 256, 0)
    return weight**2, 2 - weight


def name_of(lab: Triple) -> str:
    """The name that fits a color best, a key of PRESETS; empty if none does."""
    color, misfit = np.array([lab]), dict[str, float]()
    for preset in PRESETS:
        for weight, away in (_of_its_hues(color, preset), typical_of(color, preset)):
            if weight[0] > 0:
                misfit[preset] = float(away[0])
    return min(misfit, key=misfit.__getitem__, default='')
