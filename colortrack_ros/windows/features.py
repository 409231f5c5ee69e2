"""Appearance of a part of a picture: oriented gradients and colors on a grid of cells."""

from functools import cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.data import Indices

Pixels = NDArray[np.uint8]
Features = NDArray[np.float32]

CELL = 4
"""Side of a cell [px of a patch], as in the histograms of Staple (Bertinetto et al. 2016, 4)."""

ORIENTATIONS = 9
"""Directions of gradients in half a turn (Dalal and Triggs 2005, 6.3)."""

CLIP = 0.4
"""Largest component of a cell's histogram. Felzenszwalb et al. (2010) take 0.2 and sum four
normalizations with a weight of one half; here there is one."""

FLAT = 4.0
"""Sum of gradients in a cell that counts as none: a quarter of a gray level at each pixel, as
rounding causes."""


class Cutout(NamedTuple):
    """A part of a picture.

    pixels: (rows, columns) gray, or (rows, columns, 3); center: (u, v) of its middle [px]; times:
    side, in pixels of the picture, of the square that each of them averages.
    """

    pixels: Pixels
    center: Floats
    times: int

    @property
    def size(self) -> Indices:
        """Width and height [px of the picture]."""
        return self.times * np.array(self.pixels.shape[1::-1])


def cut(frame: Frame, center: Floats, size: Floats, step: float) -> Cutout:
    """Return about the part of a picture around a center, at whole pixels.

    Outside the picture, its border is repeated.

    :param center: (u, v) [px].
    :param size: width and height of the part [px].
    :param step: pixels of the picture per sample that will be taken of it. Interpolation mixes two
        on each axis; where it would skip some, the part is halved, by means.
    """
    halvings = int(np.log2(max(step, 1.0)))
    times = 1 << halvings
    side = times * np.maximum(np.rint(size / times).astype(int), 1)
    if times == 1:  # odd around pixels, even around borders of pixels
        side += (side + np.rint(2 * center).astype(int) + 1) % 2
    low = np.rint(center - (side - 1) / 2).astype(int)
    pixels = _between(frame.image, low, low + side)
    for _ in range(halvings):
        half = pixels.shape[1] // 2, pixels.shape[0] // 2
        pixels = np.asarray(cv2.resize(pixels, half, interpolation=cv2.INTER_AREA), np.uint8)
    return Cutout(pixels, low + (side - 1) / 2, times)


def _between(image: Pixels, low: Indices, high: Indices) -> Pixels:
    """Return the part of a picture from low to high, (u, v), excluded."""
    limit = np.array(image.shape[1::-1])
    # Farther outside there is nothing but the same border.
    out = np.clip(low, 1 - (high - low), limit - 1) - low
    low, high = low + out, high + out
    left, top = np.maximum(low, 0).tolist()
    right, bottom = np.minimum(high, limit).tolist()
    part = image[top:bottom, left:right]
    part = part[..., :3] if image.ndim == 3 else part
    missing = top - low[1], high[1] - bottom, left - low[0], high[0] - right
    if not any(missing):
        return part
    return np.asarray(cv2.copyMakeBorder(part, *missing, cv2.BORDER_REPLICATE), np.uint8)


def to_gray(patch: Pixels, encoding: str) -> Features:
    """Return the gray levels, (rows, columns), of a patch in that encoding."""
    if patch.ndim == 3:
        code = cv2.COLOR_BGR2GRAY if encoding.startswith('bgr') else cv2.COLOR_RGB2GRAY
        return np.asarray(cv2.cvtColor(patch, code), np.float32)
    return patch.astype(np.float32)


def oriented_gradients(gray: Features) -> tuple[Features, Features]:
    """Return histograms of oriented gradients of each cell (Dalal and Triggs 2005).

    Each gradient is split between the two nearest of the directions in a whole turn; the histogram
    over half a turn adds up opposite ones. Histograms are normalized by the gradients of the cells
    around.

    :param gray: (rows, columns), multiples of CELL.
    :return: sums and differences of opposite directions, (ORIENTATIONS, rows / CELL, columns /
        CELL) each.
    """
    rows, columns = gray.shape
    count, cells = 2 * ORIENTATIONS, rows // CELL * (columns // CELL)
    du, dv = np.zeros((2, rows, columns), np.float32)  # none is known at the borders
    np.subtract(gray[:, 2:], gray[:, :-2], out=du[:, 1:-1])
    np.subtract(gray[2:], gray[:-2], out=dv[1:-1])
    # The last bit of cartToPolar's magnitude depends on the alignment of its arrays (OpenCV 4.6).
    magnitude = np.sqrt(du * du + dv * dv)
    angle = np.asarray(cv2.phase(du, dv)) * np.float32(count / (2 * np.pi))
    lower = np.floor(angle)
    upper_share = magnitude * (angle - lower)
    bins = (lower * np.float32(cells) + _cells(rows, columns)).ravel().astype(np.intp)
    sums = np.bincount(bins, (magnitude - upper_share).ravel(), (count + 2) * cells)
    sums[cells:] += np.bincount(bins, upper_share.ravel(), (count + 1) * cells)  # the next bins
    sums[: 2 * cells] += sums[count * cells :]  # past a whole turn
    signed = sums[: count * cells].astype(np.float32)
    signed = signed.reshape(count, rows // CELL, columns // CELL)
    half = signed[:ORIENTATIONS] + signed[ORIENTATIONS:]
    energy = cv2.boxFilter((half * half).sum(axis=0), -1, (3, 3), normalize=False)
    norm = 1 / np.sqrt(energy + np.float32(FLAT**2))
    signed *= norm
    half *= norm
    for histogram in (signed, half):
        np.minimum(histogram, np.float32(CLIP), out=histogram)
    return half, signed[:ORIENTATIONS] - signed[ORIENTATIONS:]


@cache
def _cells(rows: int, columns: int) -> Features:
    """Return the index of each pixel's cell, (rows, columns). Floats hold it, and each bin."""
    cell = np.arange(rows)[:, None] // CELL * (columns // CELL) + np.arange(columns) // CELL
    return cell.astype(np.float32)


def describe(patch: Pixels, encoding: str) -> Features:
    """Return gradients and mean colors of the cells: (channels, rows / CELL, columns / CELL).

    Weighted so, sums and differences of opposite directions correlate as these and their sums do,
    with two thirds of the channels: a^2 + b^2 + (a + b)^2 = 3/2 (a + b)^2 + 1/2 (a - b)^2.
    """
    half, difference = oriented_gradients(to_gray(patch, encoding))
    rows, columns = half.shape[1:]
    colors = cv2.resize(patch, (columns, rows), interpolation=cv2.INTER_AREA)
    colors = colors.reshape(rows, columns, -1).transpose(2, 0, 1) / np.float32(255)
    half *= np.float32(1.5**0.5)
    difference *= np.float32(0.5**0.5)
    return np.concatenate([half, difference, colors - np.float32(0.5)])
