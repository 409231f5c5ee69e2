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
from colortrack_ros.detection.dither import is_dithered
from colortrack_ros.encodings import plain

LOOK_INTERVAL = 0.25
"""Interval between two estimates [s], each of 0.4 ms at 640x480, of noisy pictures 3 ms. Assumed:
1 % of the time."""

ROWS = 30
"""Number of rows of a picture that are read. Assumed: every sixteenth of 640x480."""

PER_BLOCK = 16
"""Pixels of a row that are one block, whose second differences have one mean. Assumed: as wide as
a macroblock, and with 32 differences."""

EVEN_SHARE = 0.25
"""Share of the blocks that are taken to show noise only. Of 63 films and sequences that cameras
have compressed, texture adds up to 1.1 levels there, and up to 1.4 at the median."""

CLIPPED, CUT_SHARE = 3, 1 / 8
"""Levels nearer than this to 0 or 255 are at the limit of the camera, where noise is cut off, and
the largest share of a block that may be there. Assumed: noise of 12 levels on a wall of 14 reaches
it with a sixth, of 8 with a twelfth."""

FEWEST_BLOCKS, LEAST_MEASURED = 20, 0.1
"""Fewer blocks, and a smaller share of all, tell nothing. Assumed: a twentieth is the order of the
error of so many; letters on black are seen in 3 %."""

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

LEFT_OF_DITHER = 2.5
"""Noise that an average over SIDES[0] leaves of a dithered picture [levels]: 1.0 to 2.5 in six
films. Where it is trouble, SIDES[1] is taken: a dull green ball is found in 29 to 95 % of the
frames of a dithered film with the first, in 98 to 100 % with the second."""

OF_TEXTURE = 0.5
"""Share that the average over SIDES[1] leaves of a texture, at least. Of foliage, carpets, and
halftones it is 0.44 to 1.2, of noise 0.19, in YUYV, NV12, and Bayer 0.27, 0.36, and 0.42."""


class Smoothing:
    """Averages each pixel of a frame with those around it.

    :param side: of the square that is averaged [px]; 0 finds it from the noise of the pictures.
    """

    def __init__(self, side: int) -> None:
        self._given = side
        self._found = 1
        self._looked: int | None = None

    def smooth(self, frame: Frame, chroma: float = 0.0) -> Frame:
        """The frame, averaged; the same object where nothing is to be done.

        :param chroma: of the dullest color to find so [CIELAB units].
        """
        side = self._given or self._find(frame, max(UNNOTICED, chroma / VIVID))
        if side == 1 or not frame.image.size:
            return frame
        frame = plain(frame)
        return replace(frame, image=np.asarray(cv2.blur(frame.image, (side, side)), np.uint8))

    def _find(self, frame: Frame, quiet: float) -> int:
        """The side for the noise of the last picture that was looked at."""
        last = self._looked
        if last is None or not 0 <= frame.stamp - last < LOOK_INTERVAL * NANOSECONDS:
            self._looked, self._found = frame.stamp, side_for(plain(frame).image, quiet)
        return self._found


def side_for(image: NDArray[np.uint8], quiet: float = UNNOTICED) -> int:
    """The least side whose average leaves a quiet picture [px]; 1 if it is quiet enough as it is.

    It is 1 for textures, too, of which an average leaves more than of noise. What is dithered has
    none in even areas of a color of its palette; what it needs depends on the colors alone.

    :param image: as for :func:`color_noise`.
    :param quiet: noise that may be left [levels].
    """
    if is_dithered(image):
        return SIDES[0] if quiet >= LEFT_OF_DITHER else SIDES[1]
    noise = color_noise(image)
    if noise < LOUD * quiet or color_noise(image, SIDES[1]) > OF_TEXTURE * noise:
        return 1
    return next((side for side in SIDES if color_noise(image, side) <= quiet), SIDES[-1])


def color_noise(image: NDArray[np.uint8], side: int = 1) -> float:
    """Standard deviation of the noise of a channel that the other channels do not share [levels].

    What they share is lightness, which colors tolerate more of. From second differences, which a
    gradient has none of (Immerkaer 1996, in one dimension).

    :param image: (H, W, channels) or (H, W); one of a single channel has none.
    :param side: of the square over which it is averaged first [px].
    """
    apart = side + 1  # pixels that share no noise: neighbors may have one chroma sample
    number = (image.shape[1] - 2 * apart) // PER_BLOCK
    if image.ndim == 2 or image.shape[2] < 3 or number <= 0 or len(image) < side:
        return 0.0
    rows = _averaged_rows(image, side)
    middle, blocks = slice(apart, apart + number * PER_BLOCK), (len(rows), number, -1)
    hue = rows[..., ::2] - rows[..., 1:2]
    bend = np.abs(hue[:, : -2 * apart] - 2 * hue[:, apart:-apart] + hue[:, 2 * apart :])
    mean = bend[:, : number * PER_BLOCK].reshape(blocks).mean(axis=2)
    inner = rows[:, middle].reshape(blocks)
    cut = ((inner < CLIPPED) | (inner > 255 - CLIPPED)).mean(axis=2)
    seen = mean[cut <= CUT_SHARE]
    if seen.size < max(FEWEST_BLOCKS, LEAST_MEASURED * mean.size):
        return 0.0
    return float(np.quantile(seen, EVEN_SHARE)) / SECOND_DIFFERENCE


def _averaged_rows(image: NDArray[np.uint8], side: int) -> NDArray[np.int16]:
    """Some ROWS rows, (R, W, 3), of the picture averaged over squares."""
    first = np.arange(0, len(image) - side + 1, max(1, len(image) // ROWS))
    bands = image[first[:, None] + np.arange(side), :, :3]
    averaged = cv2.blur(bands.reshape(-1, image.shape[1], 3), (side, side))
    return averaged[side // 2 :: side].astype(np.int16)
