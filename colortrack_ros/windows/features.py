"""Appearance of a part of a picture: oriented gradients and colors on a grid of cells."""

from functools import cache

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

COARSE = 2.0
"""Pixels of the picture per pixel of the patch from which on interpolation would skip some:
it mixes two on each axis."""


def sample(frame: Frame, center: Floats, size: Floats, out: tuple[int, int]) -> Pixels:
    """Return the part of a picture around a center, resampled.

    Outside the picture, its border is repeated.

    :param center: (u, v) [px].
    :param size: width and height of the part [px].
    :param out: columns and rows of the result.
    :return: (rows, columns) gray, or (rows, columns, 3).
    """
    limit = np.array(frame.image.shape[1::-1])
    step = size / out
    low = np.floor(center - size / 2).astype(int) - 1
    part, rim = _cut(frame.image, low, low + np.ceil(size).astype(int) + 3, limit)
    corner = center - step * (np.array(out) - 1) / 2 - low - rim
    while step.min() >= COARSE and min(part.shape[:2]) > 1:  # against aliases: halve it, by means
        columns, rows = part.shape[1] // 2, part.shape[0] // 2
        part = part[: 2 * rows, : 2 * columns]
        part = np.asarray(cv2.resize(part, (columns, rows), interpolation=cv2.INTER_AREA), np.uint8)
        step, corner = step / 2, (corner - 0.5) / 2
    matrix = np.array([[step[0], 0, corner[0]], [0, step[1], corner[1]]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    warped = cv2.warpAffine(part, matrix, out, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(warped, np.uint8)


def _cut(image: Pixels, low: Indices, high: Indices, limit: Indices) -> tuple[Pixels, Indices]:
    """Return what of the part from low to high, (u, v), excluded, is inside the picture.

    :return: the part, and how much is missing to the left and above, (u, v).
    """
    first = np.clip(low, 0, limit - 1)
    last = np.clip(high, first + 1, limit)
    part = image[first[1] : last[1], first[0] : last[0]]
    return part[..., :3] if image.ndim == 3 else part, first - low


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
    count, cell = 2 * ORIENTATIONS, _cells(rows, columns)
    cells = rows // CELL * (columns // CELL)
    du = cv2.Sobel(gray, cv2.CV_32F, 1, 0, ksize=1)
    dv = cv2.Sobel(gray, cv2.CV_32F, 0, 1, ksize=1)
    # The last bit of cartToPolar's magnitude depends on the alignment of its arrays (OpenCV 4.6).
    magnitude = np.sqrt(du * du + dv * dv)
    angle = np.asarray(cv2.phase(du, dv)) * np.float32(count / (2 * np.pi))
    lower = np.floor(angle)
    upper_share = magnitude * (angle - lower)
    bins = (lower.astype(np.intp) * cells + cell).ravel()
    sums = np.bincount(bins, (magnitude - upper_share).ravel(), (count + 2) * cells)
    sums[cells:] += np.bincount(bins, upper_share.ravel(), (count + 1) * cells)  # the next bins
    sums[: 2 * cells] += sums[count * cells :]  # past a whole turn
    signed = sums[: count * cells].astype(np.float32)
    signed = signed.reshape(count, rows // CELL, columns // CELL)
    half = signed[:ORIENTATIONS] + signed[ORIENTATIONS:]
    energy = cv2.boxFilter((half**2).sum(axis=0), -1, (3, 3), normalize=False)
    norm = 1 / np.sqrt(energy + np.float32(FLAT**2))
    signed = np.minimum(signed * norm, np.float32(CLIP))
    difference = signed[:ORIENTATIONS] - signed[ORIENTATIONS:]
    return np.minimum(half * norm, np.float32(CLIP)), difference


@cache
def _cells(rows: int, columns: int) -> Indices:
    """Return the index of each pixel's cell, (rows, columns)."""
    return np.arange(rows)[:, None] // CELL * (columns // CELL) + np.arange(columns) // CELL


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
