"""The 2^16 cells that group the 2^24 colors, with bounds of CIELAB over each."""

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.lab import cube_root_or_line_slope
from colortrack_ros.detection.lab import lab_from_linear
from colortrack_ros.detection.lab import LINEAR
from colortrack_ros.detection.lab import WHITE_TO_ONE

CELLS = 1 << 16
"""Number of cells: 5 bits of red, 6 of green, 5 of blue."""

TO_CELL = {
    'bgr8': cv2.COLOR_BGR2BGR565,
    'rgb8': cv2.COLOR_RGB2BGR565,
    'bgra8': cv2.COLOR_BGRA2BGR565,
    'rgba8': cv2.COLOR_RGBA2BGR565,
}
WITH_FOURTH = {'bgr8': 'bgra8', 'rgb8': 'rgba8'}
"""Encodings of pixels of three channels that were copied as four bytes each, which is faster."""

IN_CELL = np.stack(np.meshgrid(range(8), range(4), range(8), indexing='ij'), -1).reshape(-1, 3)

_MARGIN = 1e-6
"""Margin of the bounds for rounding, which is below 1e-11 of a CIELAB unit in double precision."""


def corner_of(cell: NDArray[np.intp]) -> NDArray[np.intp]:
    """(N, 3) least red, green and blue in each cell."""
    return np.stack([cell >> 11 << 3, (cell >> 5 & 63) << 2, (cell & 31) << 3], axis=-1)


def cell_of(colors: NDArray[np.integer]) -> NDArray[np.intp]:
    """(N,) the cell of each color, red << 16 | green << 8 | blue."""
    return np.asarray(colors >> 8 & 0xF800 | colors >> 5 & 0x07E0 | colors >> 3 & 0x001F, np.intp)


def colors_in(cells: NDArray[np.intp]) -> NDArray[np.intp]:
    """(N, 256) the colors, red << 16 | green << 8 | blue, in each cell."""
    places = np.array([1 << 16, 1 << 8, 1])
    return np.asarray((corner_of(cells) @ places)[:, None] + IN_CELL @ places)


@lru_cache(maxsize=1)
def cell_bounds() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Bounds of CIELAB over each cell: center plus and minus radius, for each axis.

    L is monotonic in red, green and blue. For a and b, the mean value theorem bounds the distance
    from the middle of the cell by the largest slope in it; f' of CIE 1976 decreases monotonically.

    :returns: centers and radii, both (3, 65536).
    """
    low = corner_of(np.arange(1 << 16))
    low_linear, high_linear = LINEAR[low], LINEAR[low + IN_CELL[-1]]
    center = lab_from_linear((low_linear + high_linear) / 2)
    half = (high_linear - low_linear) / 2
    steep = cube_root_or_line_slope(low_linear @ WHITE_TO_ONE.T)
    flat = cube_root_or_line_slope(high_linear @ WHITE_TO_ONE.T)
    radius = np.empty_like(center)
    lightness = np.stack([lab_from_linear(end)[:, 0] for end in (low_linear, high_linear)])
    center[:, 0] = lightness.mean(axis=0)
    radius[:, 0] = np.ptp(lightness, axis=0) / 2
    for axis, (plus, minus, scale) in enumerate(((0, 1, 500), (1, 2, 200)), start=1):
        rising = steep[:, [plus]] * WHITE_TO_ONE[plus] - flat[:, [minus]] * WHITE_TO_ONE[minus]
        falling = flat[:, [plus]] * WHITE_TO_ONE[plus] - steep[:, [minus]] * WHITE_TO_ONE[minus]
        slope = np.maximum(np.abs(rising), np.abs(falling))
        radius[:, axis] = scale * (slope * half).sum(axis=1)
    return np.ascontiguousarray(center.T), np.ascontiguousarray(radius.T) + _MARGIN


def lab_of_cells(cells: NDArray[np.intp]) -> NDArray[np.float64]:
    """(N, 3) CIELAB of the middles of cells, in columns: NumPy is five times as fast with them."""
    return cell_bounds()[0].take(cells, axis=1).T


def distance_bounds(
    center: NDArray[np.float64],
    radius: NDArray[np.float64],
    samples: NDArray[np.float64],
    stretch: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(65536,) each: lower and upper bound of D^2 to the nearest sample over each cell."""
    nearest, farthest = np.full((2, center.shape[1]), np.inf)
    near, far = np.empty((2, *center.shape))
    for sample in samples:
        np.abs(np.subtract(center, sample[:, None], out=far), out=far)
        np.maximum(np.subtract(far, radius, out=near), 0, out=near)
        far += radius
        for way, least in ((near, nearest), (far, farthest)):
            way *= stretch[:, None]
            way *= way
            np.minimum(least, way.sum(axis=0), out=least)
    return nearest, farthest


def least_squared(
    lab: NDArray[np.float64], samples: NDArray[np.float64], stretch: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N,) D^2 of colors, (3, N), to the nearest sample."""
    least = np.full(lab.shape[1], np.inf)
    for sample in samples:
        way = (lab - sample[:, None]) * stretch[:, None]
        way *= way
        np.minimum(least, way[0] + way[1] + way[2], out=least)
    return least


def cells_of(picture: NDArray[np.uint8], encoding: str) -> NDArray[np.uint16]:
    """(H, W) cell of each pixel; a fourth channel that the encoding has not is ignored."""
    if picture.shape[2:] == (4,):
        encoding = WITH_FOURTH.get(encoding, encoding)
    code = TO_CELL.get(encoding, cv2.COLOR_GRAY2BGR565)
    return cv2.cvtColor(picture, code).view(np.uint16).reshape(picture.shape[:2])
