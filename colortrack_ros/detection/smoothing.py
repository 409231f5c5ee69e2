"""Averages the pixels of noisy pictures before their colors are looked up.

Noise takes single pixels of an object out of its color, and the erosion then the pixels around
each of them. Averaged over n by n pixels, noise that is independent is 1/n as large.
"""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.encodings import plain

LOOK_INTERVAL = 0.25
"""Interval between two estimates [s], each of 0.7 ms at 640x480, of noisy pictures 1.5. Assumed:
0.5 % of the time."""

ROWS = 60
"""Number of rows of a picture that are read. Assumed: every eighth of 640x480."""

PER_BLOCK = 16
"""Pixels of a row that are one block, whose second differences have one mean. Assumed: as wide as
a macroblock, and with 32 differences."""

EVEN_SHARE = 0.25
"""Share of the blocks that are taken to show noise only. Of 65 films and pictures that cameras have
compressed, texture adds up to 1.0 level there, and up to 1.4 at the median."""

CLIPPED = 8
"""Levels nearer than this to 0 or 255 are at the limit of the camera, where noise is cut off.
Assumed: noise of 3 levels keeps away from it."""

FEWEST_BLOCKS = 20
"""Fewer tell nothing. Assumed: a twentieth is then the order of their error."""

SECOND_DIFFERENCE = float(np.sqrt(6) * np.sqrt(2 / np.pi) * np.sqrt(2))
"""Mean absolute second difference of the difference of two channels, over the standard deviation of
the noise of each, which is normal: weights 1, -2, 1, of two channels."""

UNNOTICED = 1.5
"""Noise that is no trouble for any color [levels]. Chosen: with 2.0, a dull green ball of a real
film, in noise of 8 to 20 levels, is taken for the wall in 5 of 20 runs, in 1 with this."""

VIVID = 16.0
"""Chroma of a color, its distance from gray, over the noise that is no trouble for it [CIELAB units
per level]. Without an average, red cups (chroma 71) in noise of 8 levels are found as before, in
noise of 12 in 82 % instead of 94 % of the frames."""

LOUD = 2.0
"""Noise that pixels are averaged for, over that which is no trouble: it has to be worth what it
costs, outlines that are less sharp. A ball of chroma 17 in noise of 4 levels is found in 63 to 87 %
of the frames as it is, with an average in all."""

SIDES = (3, 5, 7, 9)
"""Sides that are tried [px]. Assumed: in noise that needs the last, what is smaller is lost."""


class Smoothing:
    """Averages each pixel of a frame with those around it.

    :param side: of the square that is averaged [px]; 0 finds it from the noise of the pictures.
    :param chroma: of the dullest color to find so [CIELAB units].
    """

    def __init__(self, side: int, chroma: float = 0.0) -> None:
        self._given = side
        self._quiet = max(UNNOTICED, chroma / VIVID)
        self._found = 1
        self._looked: int | None = None

    def smooth(self, frame: Frame) -> Frame:
        """The frame, averaged; the same object where nothing is to be done."""
        side = self._given or self._find(frame)
        if side == 1 or not frame.image.size:
            return frame
        frame = plain(frame)
        return replace(frame, image=averaged(frame.image, side))

    def _find(self, frame: Frame) -> int:
        """The side for the noise of the last picture that was looked at."""
        last = self._looked
        if last is None or not 0 <= frame.stamp - last < LOOK_INTERVAL * NANOSECONDS:
            self._looked, self._found = frame.stamp, side_for(plain(frame).image, self._quiet)
        return self._found


def side_for(image: NDArray[np.uint8], quiet: float = UNNOTICED) -> int:
    """The least side whose average leaves a quiet picture [px]; 1 if it is quiet enough as it is.

    :param image: as for :func:`color_noise`.
    :param quiet: noise that may be left [levels].
    """
    if color_noise(image) < LOUD * quiet:
        return 1
    is_quiet = (color_noise(averaged(image, side), side) <= quiet for side in SIDES)
    return next((side for side, enough in zip(SIDES, is_quiet, strict=True) if enough), SIDES[-1])


def averaged(image: NDArray[np.uint8], side: int) -> NDArray[np.uint8]:
    """Each pixel's mean over a square around it; side: of that [px]."""
    return np.asarray(cv2.blur(image, (side, side)), np.uint8)


def color_noise(image: NDArray[np.uint8], side: int = 1) -> float:
    """Standard deviation of the noise of a channel that the other channels do not share [levels].

    What they share is lightness, which colors tolerate more of. From second differences, which a
    gradient has none of (Immerkaer 1996, in one dimension).

    :param image: (H, W, channels) or (H, W); one of a single channel has none.
    :param side: of the square over which it is averaged [px].
    """
    if image.ndim == 2 or image.shape[2] < 3:
        return 0.0
    rows = image[:: max(1, len(image) // ROWS), :, :3].astype(np.int16)
    apart = side + 1  # pixels that share no noise: neighbors may have one chroma sample
    number = (rows.shape[1] - 2 * apart) // PER_BLOCK
    if number <= 0:
        return 0.0
    middle, blocks = slice(apart, apart + number * PER_BLOCK), (len(rows), number, -1)
    hue = rows[..., ::2] - rows[..., 1:2]
    bend = np.abs(hue[:, : -2 * apart] - 2 * hue[:, apart:-apart] + hue[:, 2 * apart :])
    mean = bend[:, : number * PER_BLOCK].reshape(blocks).mean(axis=2)
    inner = rows[:, middle].reshape(blocks)
    seen = mean[(inner.min(axis=2) >= CLIPPED) & (inner.max(axis=2) <= 255 - CLIPPED)]
    if seen.size < FEWEST_BLOCKS:
        return 0.0
    return float(np.quantile(seen, EVEN_SHARE)) / SECOND_DIFFERENCE
