"""CIELAB, Pegoretti 2021, (2.1): the reference computation that decides on the color of a pixel.

Everything faster in this room is a table computed with it, and agrees with it to the bit.
"""

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

Triple = tuple[float, float, float]
"""A color: L 0..100, a and b -128..128; or lengths along these axes."""

SRGB_TO_XYZ = np.array(
    [
        [0.412453, 0.357580, 0.180423],
        [0.212671, 0.715160, 0.072169],
        [0.019334, 0.119193, 0.950227],
    ]
)
"""Linear sRGB to CIE XYZ, the matrix of OpenCV (ITU-R BT.709 primaries); its rows sum to the white
point D65, so gray has a = b = 0."""

WHITE_TO_ONE = SRGB_TO_XYZ / SRGB_TO_XYZ.sum(axis=1, keepdims=True)
"""Linear sRGB to XYZ over the white point."""

_CUBE_ROOT_FROM = (6 / 29) ** 3
"""Ratio of X, Y, Z to white from which CIE 1976 uses the cube root (CIE 15:2004): (24/116)^3."""

_SLOPE = (29 / 6) ** 2 / 3
"""Slope of the cube root there, 1 / (3 (6/29)^2); the line below continues with it (CIE
15:2004)."""


def linear_from_srgb(srgb: ArrayLike) -> NDArray[np.float64]:
    """Undo the transfer curve of sRGB (IEC 61966-2-1).

    :param srgb: any shape, 0..255.
    :returns: the same shape, 0..1, proportional to light.
    """
    value = np.asarray(srgb, np.float64) / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


LINEAR = linear_from_srgb(np.arange(256))
"""The inverse transfer curve at the 256 values of a byte."""


def cube_root_or_line(ratio: NDArray[np.float64]) -> NDArray[np.float64]:
    """The f of CIE 1976: the cube root, and its tangent below (6/29)^3."""
    return np.where(ratio > _CUBE_ROOT_FROM, np.cbrt(ratio), _SLOPE * ratio + 4 / 29)


def cube_root_or_line_slope(ratio: NDArray[np.float64]) -> NDArray[np.float64]:
    """The derivative of :func:`cube_root_or_line`; it decreases with the ratio."""
    return 1 / (3 * np.cbrt(np.maximum(ratio, _CUBE_ROOT_FROM)) ** 2)


def lab_from_linear(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """CIE 1976 L*a*b* of linear sRGB, white point D65, 2 degrees.

    Sums are written out instead of using a matrix product: the result for a color must not depend
    on how many others are converted with it.

    :param linear: (..., 3) red, green, blue, 0..1.
    :returns: (..., 3) L 0..100, a and b signed.
    """
    red, green, blue = linear[..., 0], linear[..., 1], linear[..., 2]
    return _lab_from_ratios(
        np.array([row[0] * red + row[1] * green + row[2] * blue for row in WHITE_TO_ONE])
    )


def _lab_from_ratios(xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3) CIELAB of (3, ...) X, Y, Z over the white point."""
    fx, fy, fz = cube_root_or_line(xyz)
    lab = np.empty((*fx.shape, 3))
    lab[..., 0], lab[..., 1], lab[..., 2] = 116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)
    return lab


_OF_RED, _OF_GREEN, _OF_BLUE = WHITE_TO_ONE.T[:, :, None] * LINEAR
"""X, Y, Z over the white point, (3, 256), that the values of one channel add."""


def lab_from_rgb(rgb: NDArray[np.integer]) -> NDArray[np.float64]:
    """CIELAB of 8-bit sRGB colors.

    :param rgb: (..., 3) integers, 0..255.
    :returns: (..., 3) L 0..100, a and b signed.
    """
    red, green = _OF_RED.take(rgb[..., 0], axis=1), _OF_GREEN.take(rgb[..., 1], axis=1)
    return _lab_from_ratios(red + green + _OF_BLUE.take(rgb[..., 2], axis=1))


def linear_from_lab(lab: ArrayLike) -> NDArray[np.float64]:
    """The linear sRGB values of CIELAB colors; the inverse of :func:`lab_from_linear`.

    :param lab: (..., 3).
    :returns: (..., 3) red, green, blue; below 0 or above 1 outside sRGB.
    """
    L, a, b = np.moveaxis(np.asarray(lab, np.float64), -1, 0)
    root = np.stack([(L + 16) / 116 + a / 500, (L + 16) / 116, (L + 16) / 116 - b / 200], axis=-1)
    xyz = np.where(root**3 > _CUBE_ROOT_FROM, root**3, (root - 4 / 29) / _SLOPE)
    return np.asarray(xyz @ np.linalg.inv(WHITE_TO_ONE).T)


def rgb_from_lab(lab: ArrayLike) -> NDArray[np.intp]:
    """The 8-bit sRGB colors nearest to CIELAB colors; the inverse of :func:`lab_from_rgb`.

    :param lab: (..., 3); colors outside sRGB are clipped.
    """
    linear = np.clip(linear_from_lab(lab), 0, 1)
    curved = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.rint(255 * curved).astype(np.intp)
