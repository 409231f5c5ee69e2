"""The cost functions of Vidal 2009, Table 3.1, at every position in a search region.

I_1 is the template, and I_2 the window of the same size at a position; i_1 and i_2 are their means.
Under the gain i_1 / i_2 of LSAD and LSSD a window that is entirely black stays black. A quotient 0
/ 0 in NCC and ZNCC is 0.
"""

from collections.abc import Callable
from typing import NamedTuple

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy import fft

Picture = NDArray[np.float32]


class Cost(NamedTuple):
    """A cost function.

    surface: maps a template (h, w) and a region (H, W), both float32, to the cost at each position,
    (H - h + 1, W - w + 1); ceiling: for functions to maximize, the score of a template against
    itself.
    """

    surface: Callable[[Picture, Picture], NDArray]
    ceiling: Callable[[Picture], float] | None = None


def distances(name: str, template: Picture, region: Picture) -> NDArray:
    """Distance at each position (the matrix of 3.4.1): the cost, with 0 for a perfect match.

    :param name: of the cost function, a key of COSTS.
    :param template: (h, w) gray levels.
    :param region: (H, W) gray levels, no smaller than the template.
    :return: (H - h + 1, W - w + 1).
    """
    cost = COSTS[name]
    surface = cost.surface(template, region)
    return surface if cost.ceiling is None else cost.ceiling(template) - surface


def _sad(template: Picture, region: Picture) -> NDArray:
    return _absolute(template, region)


def _ssd(template: Picture, region: Picture) -> NDArray:
    return cv2.matchTemplate(region, template, cv2.TM_SQDIFF)


def _zsad(template: Picture, region: Picture) -> NDArray:
    """The sum of |(I_1 - i_1) - (I_2 - i_2)|; the table lacks a pair of parentheses."""
    mean = _sums(template, region)[0] / template.size
    return _absolute(template, region, offset=template.mean() - mean)


def _zssd(template: Picture, region: Picture) -> NDArray:
    """The sum of ((I_1 - i_1) - (I_2 - i_2))^2; the table lacks a pair of parentheses."""
    template, region = _leveled(template, region)
    total, squares = _sums(template, region)
    product = cv2.matchTemplate(region, template, cv2.TM_CCOEFF)
    variation = squares - total**2 / template.size
    return np.maximum(_energy(template) - 2 * product + variation, 0)


def _lsad(template: Picture, region: Picture) -> NDArray:
    return _absolute(template, region, gain=_gain(template, _sums(template, region)[0]))


def _lssd(template: Picture, region: Picture) -> NDArray:
    total, squares = _sums(template, region)
    gain = _gain(template, total)
    product = gain * _cc(template, region)
    return np.maximum(_energy(template) - 2 * product + gain**2 * squares, 0)


def _cc(template: Picture, region: Picture) -> NDArray:
    return cv2.matchTemplate(region, template, cv2.TM_CCORR)


def _ncc(template: Picture, region: Picture) -> NDArray:
    return cv2.matchTemplate(region, template, cv2.TM_CCORR_NORMED)


def _zncc(template: Picture, region: Picture) -> NDArray:
    surface = cv2.matchTemplate(*_leveled(template, region)[::-1], cv2.TM_CCOEFF_NORMED)
    # For a template without texture OpenCV returns 1 everywhere.
    return surface if np.ptp(template) > 0 else np.zeros_like(surface)


def _ssd_frequency(template: Picture, region: Picture) -> NDArray:
    """SSD, with the correlation as a product of transforms (3.7)."""
    size = [fft.next_fast_len(n, real=True) for n in region.shape]
    spectrum = fft.rfft2(region.astype(float), size)
    spectrum *= fft.rfft2(template.astype(float), size).conj()
    squares = _sums(template, region)[1]
    product = fft.irfft2(spectrum, size)[: squares.shape[0], : squares.shape[1]]
    return np.maximum(_energy(template) - 2 * product + squares, 0)


def _absolute(
    template: Picture,
    region: Picture,
    gain: NDArray | None = None,
    offset: NDArray | None = None,
) -> NDArray:
    """The sum of |I_1 - gain I_2 - offset|, one row of positions at a time.

    :param gain, offset: of each position.
    """
    windows = sliding_window_view(region, template.shape)
    surface = np.empty(windows.shape[:2], np.float32)
    for row, places in enumerate(windows):
        shifted = places if gain is None else places * gain[row, :, None, None].astype(np.float32)
        rest = template - shifted
        if offset is not None:
            rest -= offset[row, :, None, None].astype(np.float32)
        surface[row] = np.abs(rest, out=rest).sum(axis=(1, 2))
    return surface


def _sums(template: Picture, region: Picture) -> tuple[NDArray, NDArray]:
    """The sum and the sum of squares of the window at each position."""
    h, w = template.shape
    tables = cv2.integral2(region, sdepth=cv2.CV_64F, sqdepth=cv2.CV_64F)
    total, squares = (t[h:, w:] - t[:-h, w:] - t[h:, :-w] + t[:-h, :-w] for t in tables)
    return total, squares


def _gain(template: Picture, total: NDArray) -> NDArray:
    """i_1 / i_2."""
    dark = total <= 0
    return np.where(dark, 0.0, template.sum(dtype=float) / np.where(dark, 1.0, total))


def _leveled(template: Picture, region: Picture) -> tuple[Picture, Picture]:
    """Both minus their means: a cost that ignores brightness should lose no digits to it."""
    return template - template.mean(), region - region.mean()


def _energy(template: Picture) -> float:
    return float(np.vdot(template.astype(float), template))


COSTS = {
    'sad': Cost(_sad),
    'ssd': Cost(_ssd),
    'zsad': Cost(_zsad),
    'zssd': Cost(_zssd),
    'lsad': Cost(_lsad),
    'lssd': Cost(_lssd),
    'cc': Cost(_cc, _energy),
    'ncc': Cost(_ncc, lambda _: 1.0),
    'zncc': Cost(_zncc, lambda _: 1.0),
    'ssd_frequency': Cost(_ssd_frequency),
}
"""Cost functions by name: the nine of the table, and SSD again, in the frequency domain."""
