"""Dithered pictures of a coarse palette, such as a GIF made without a palette of its own.

Such a picture has few levels of red, green, and blue, and between two of them a checker of both: a
red cup is a checker of orange, crimson, and dark red, and none of its pixels has its color.
"""

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.detection.cells import cells_of
from colortrack_ros.detection.extent import SHAPE
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.lab import rgb_from_lab
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.pixels import rgb_of
from colortrack_ros.detection.reference import ReferenceColor

LOOKED_AT = 30
"""Number of rows that are read. Assumed: every sixteenth of 640x480."""

COARSE = 8
"""Largest number of levels of a channel in a coarse palette: 3 bits. Palettes of 32 colors that are
made for a film have 22 and more, and things are found in it as in the film."""

CHECKERED = 1 / 8
"""Least share of the pixels that differ from both of their neighbors. Films have 0.41 to 0.97 when
dithered, drawings 0.02 to 0.07."""

DITHER_SQUARE = 7
"""Side of the square within which pixels of a color are counted [px]. Assumed: as wide as most of
the pattern, which repeats after 8."""

AVERAGED = 5
"""Side of the square whose mean is the color that is shown [px]. Assumed: it leaves a twelfth of
the pattern."""

SHOWN_SHARE = 1 / 16
"""Least share of such a square that pixels of a thing's color have: one of 4 by 4 of the pattern.
Assumed: rarer ones are seldom picked, and elsewhere they are not the thing's."""

NEAREST_OF_SHOWN = 1 / 4
"""Share of the pixels that are taken for the thing's. Chosen: with half, a pixel of a yellow box is
taken for the wall behind it; of red cups and blue caps all of 1/10 to 1/2 give their color."""

MOST_SHOWN = 4096
"""Most pixels that are read for the color that a thing shows, spread over all that show it. Chosen:
3 ms; all pixels of a wall at 1920x1080 take a second."""


def is_dithered(image: NDArray[np.uint8]) -> bool:
    """Whether a picture, (H, W, channels) or (H, W), is a checker of few colors."""
    if image.ndim == 2 or image.shape[2] < 3:
        return False
    rows = image[:: max(1, len(image) // LOOKED_AT), :, :3]
    if any(np.count_nonzero(np.bincount(rows[..., k].ravel())) > COARSE for k in range(3)):
        return False
    differs = (rows[:, 1:] != rows[:, :-1]).any(axis=2)
    lone = differs[:, 1:] & differs[:, :-1]
    return bool(lone.size and lone.mean() > CHECKERED)


def of_palette(colors: Sequence[ReferenceColor], frame: Frame) -> list[ReferenceColor]:
    """The colors of what shows them in a picture; themselves if it is not dithered.

    :param frame: as for :func:`color_shown`, if it is dithered.
    """
    if not is_dithered(frame.image):
        return list(colors)
    shown = [None if color.is_sampled else color_shown(frame, color.lab) for color in colors]
    return [replace(color, lab=lab or color.lab) for color, lab in zip(colors, shown, strict=True)]


def color_shown(frame: Frame, lab: Triple) -> Triple | None:
    """CIELAB of what shows a color of the palette, averaged.

    :param frame: dithered, with an encoding of :func:`~colortrack_ros.encodings.plain`.
    :param lab: of the palette. Of things that show it, the one whose own color is nearest is meant.
    :returns: None if no thing shows it.
    """
    own = rgb_from_lab(lab).astype(np.uint8).reshape(1, 1, 3)
    is_it = cells_of(frame.image, frame.encoding) == cells_of(own, 'rgb8')
    share = np.asarray(cv2.blur(is_it.astype(np.float32), (DITHER_SQUARE, DITHER_SQUARE)))
    dense = (is_it & (share >= SHOWN_SHARE)).nonzero()
    number = len(dense[0])
    if not number:
        return None
    averaged = np.asarray(cv2.blur(frame.image, (AVERAGED, AVERAGED)), np.uint8)
    some = np.linspace(0, number - 1, min(number, MOST_SHOWN)).astype(int)
    shown = lab_from_rgb(rgb_of(averaged[dense[0][some], dense[1][some]], frame.encoding))
    away = nearest_sample(shown, (lab,), SHAPE)
    L, a, b = np.median(shown[away <= np.quantile(away, NEAREST_OF_SHOWN)], axis=0).tolist()
    return L, a, b
