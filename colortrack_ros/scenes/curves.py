"""Motion as piecewise polynomials of time.

Only + - * / are used, so that a path is bit-identical on every machine; sine and cosine differ
between mathematical libraries.
"""

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray


class Curve:
    """Cubic pieces c0 + c1 s + c2 s^2 + c3 s^3, s = t - start of the piece [s].

    Before the first and after the last knot the outermost pieces continue.

    :param starts: (n,) start time of each piece [s], ascending.
    :param coefficients: (n, 4, columns) c0..c3 of each piece.
    """

    def __init__(self, starts: ArrayLike, coefficients: ArrayLike) -> None:
        self._starts = np.asarray(starts, float)
        self._coefficients = np.asarray(coefficients, float)

    def _pieces(self, t: NDArray[np.float64]) -> tuple[NDArray, NDArray]:
        index = np.searchsorted(self._starts, t, 'right') - 1
        index = np.clip(index, 0, len(self._starts) - 1)
        return self._coefficients[index], (t - self._starts[index])[:, None]

    def value(self, t: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (m, columns), the values at the times t (m,) [s]."""
        c, s = self._pieces(t)
        return ((c[:, 3] * s + c[:, 2]) * s + c[:, 1]) * s + c[:, 0]

    def slope(self, t: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (m, columns), the derivatives at the times t (m,) [1/s]."""
        c, s = self._pieces(t)
        return (3 * c[:, 3] * s + 2 * c[:, 2]) * s + c[:, 1]


def constant(*values: float) -> Curve:
    """Return a constant curve."""
    return Curve([0.0], [[values, *np.zeros((3, len(values)))]])


def polyline(times: ArrayLike, points: ArrayLike) -> Curve:
    """Return straight pieces through the points (n + 1, columns) at the times (n + 1,) [s]."""
    return arcs(times, points, 0.0)


def arcs(times: ArrayLike, points: ArrayLike, acceleration: ArrayLike) -> Curve:
    """Return pieces of constant acceleration through the points, as for thrown balls.

    :param acceleration: for all pieces, (columns,), or for each piece, (n, columns) [1/s^2].
    """
    p, t = np.asarray(points, float), np.asarray(times, float)
    h = np.diff(t)[:, None]
    half = np.broadcast_to(np.asarray(acceleration, float) / 2, p[1:].shape)
    c1 = (p[1:] - p[:-1]) / h - half * h
    return Curve(t[:-1], np.stack([p[:-1], c1, half, np.zeros_like(half)], axis=1))


def to_and_fro(start: float, ends: ArrayLike, straight: float, turn: float, ways: int) -> Curve:
    """Return a path straight from one of two points to the other and back, over and over.

    :param start: time when it leaves the first [s].
    :param ends: (2, columns).
    :param straight, turn: how long each way, and each turn, lasts [s].
    """
    both = np.asarray(ends, float)
    times, points, accelerations = [start], [both[0]], []
    for n in range(ways):
        here, there = both[n % 2], both[(n + 1) % 2]
        times += [times[-1] + straight, times[-1] + straight + turn]
        points += [there, there]
        accelerations += [0 * here, (here - there) * (2 / (straight * turn))]
    return arcs(times, points, np.stack(accelerations))


def spline(times: ArrayLike, points: ArrayLike) -> Curve:
    """Return a smooth curve through the points: cubic Hermite pieces, Catmull-Rom slopes."""
    p, t = np.asarray(points, float), np.asarray(times, float)[:, None]
    h, rise = np.diff(t, axis=0), np.diff(p, axis=0)
    inner = (p[2:] - p[:-2]) / (t[2:] - t[:-2])
    m = np.concatenate([rise[:1] / h[:1], inner, rise[-1:] / h[-1:]])
    c2 = (3 * rise / h - 2 * m[:-1] - m[1:]) / h
    c3 = (m[:-1] + m[1:] - 2 * rise / h) / (h * h)
    return Curve(t[:-1, 0], np.stack([p[:-1], m[:-1], c2, c3], axis=1))
