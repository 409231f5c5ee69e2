"""Random pictures that are identical on every machine.

NumPy guarantees the raw bit stream of PCG64; only + - * / are applied to it here.
"""

import numpy as np
from numpy.typing import NDArray

Color = tuple[int, int, int]
"""R, G, B, 0..255."""

BYTES_SIGMA = 147.8
"""Standard deviation of the sum of four random bytes, sqrt(4 (256^2 - 1) / 12)."""


def uniform(seed: tuple[int, ...], *shape: int) -> NDArray[np.float64]:
    """Return an array of random numbers in [0, 1), 53 bits each."""
    raw = np.random.PCG64(seed).random_raw(int(np.prod(shape)))
    return (raw >> np.uint64(11)).astype(float).reshape(shape) * 2.0**-53


def normal(seed: tuple[int, ...], *shape: int) -> NDArray[np.float64]:
    """Return approximately normal random numbers, sigma 1, within 6: sums of twelve uniform
    ones.
    """
    raw = np.random.PCG64(seed).random_raw(12 * int(np.prod(shape))) >> np.uint64(8)
    return raw.reshape(12, *shape).sum(axis=0).astype(float) * 2.0**-56 - 6


def grain(seed: tuple[int, ...], count: int, sigma: float) -> NDArray[np.int16]:
    """Return (count,) approximately normal integers, within 3.45 sigma: sums of four bytes.

    This is fast, since a picture needs a million.
    """
    raw = np.random.PCG64(seed).random_raw(count // 2 + 1).astype('<u8')
    total = raw.view(np.uint8)[: 4 * count].reshape(4, count).sum(axis=0, dtype=np.int16)
    return np.rint((total - np.int16(510)) * (sigma / BYTES_SIGMA)).astype(np.int16)


def value_noise(seed: tuple[int, ...], height: int, width: int, cell: float) -> NDArray:
    """Return (height, width), smooth noise in [-1, 1] with bumps about `cell` px wide."""
    rows, row_weights = _grid(height, cell)
    columns, column_weights = _grid(width, cell)
    lattice = 2 * uniform(seed, rows.max(initial=0) + 2, columns.max(initial=0) + 2) - 1
    w = row_weights[:, None]
    bands = lattice[rows] * (1 - w) + lattice[rows + 1] * w
    return bands[:, columns] * (1 - column_weights) + bands[:, columns + 1] * column_weights


def _grid(count: int, cell: float) -> tuple[NDArray, NDArray]:
    """Return the lattice cell of each pixel, and the smooth weight of the cell's far end there."""
    x = np.arange(count) / cell
    i = x.astype(int)
    s = x - i
    return i, s * s * (3 - 2 * s)


def plaster(
    seed: tuple[int, ...], height: int, width: int, color: Color, contrast: float = 1.0
) -> NDArray[np.uint8]:
    """Return (height, width, 3) BGR, an uneven surface of the color, brighter at the top left.

    :param contrast: 1: bumps of +-20 % of the brightness; 0: a plain surface.
    """
    relief = np.zeros((height, width))
    for octave, (cell, weight) in enumerate([(180, 0.09), (45, 0.06), (12, 0.05), (3, 0.04)]):
        relief += weight * value_noise((*seed, octave), height, width, cell)
    relief -= 0.06 * (np.arange(height) / height)[:, None] + 0.06 * np.arange(width) / width
    shade = (1.06 + contrast * relief)[..., None]
    return np.clip(shade * np.array(color[::-1], float), 0, 255).astype(np.uint8)
