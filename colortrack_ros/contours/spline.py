"""Closed quadratic B-splines in arrays: points, normals, area, centroid.

Segment i of the curve (De Bem 2007, section 3; Blake and Isard 1998, 3.2) is, for t in [0, 1]::

    x(t) = (1 - t)^2 / 2 x_{i-1} + (1/2 + t - t^2) x_i + t^2 / 2 x_{i+1}

A contour is represented by its nodes, from which its measurement lines start. Node i is the middle
of segment i, where the curve is closest to control point i: (x_{i-1} + 6 x_i + x_{i+1}) / 8.
"""

import numpy as np

from colortrack_ros.data import Floats

GAUSS = np.array([0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)])
GAUSS_WEIGHTS = np.array([5, 8, 5]) / 18
"""Gauss-Legendre points and weights, exact for the moments' degree of 5 on a segment."""

SEGMENT_POINTS = 4
"""Points of an outline on each segment. IDF1 is 0.87 and 0.81, not 0.88, with half and twice the
value on PETS S3.MF1, 0.40 and 0.38, not 0.40, on TUD Campus (``benchmark/real_contours.py FOLDER
--constants spline.SEGMENT_POINTS``)."""


class Spline:
    """Operations on contours with n nodes; the curve is linear in the nodes.

    :param count: number of nodes, n.
    :param interpolating: whether the nodes lie on the curve; if not, they are its control points,
        as in the document, and the curve runs inside them where it is convex.
    """

    def __init__(self, count: int, *, interpolating: bool = True) -> None:
        self.count = count
        control: Floats = np.eye(count)
        if interpolating:
            control = np.asarray(np.linalg.inv(_values(count, np.array([0.5]))), float)
        self._tangent = _slopes(count, np.array([0.5])) @ control
        self._value = _values(count, GAUSS) @ control
        self._slope = _slopes(count, GAUSS) @ control
        self._weight = np.tile(GAUSS_WEIGHTS, count)
        steps = (np.arange(SEGMENT_POINTS) + 0.5) / SEGMENT_POINTS
        self._sample = _values(count, steps) @ control

    def outline(self, nodes: Floats) -> Floats:
        """Return points along the curves, (..., n SEGMENT_POINTS, 2), of nodes (..., n, 2)."""
        return np.asarray(self._sample @ nodes)

    def normals(self, nodes: Floats) -> Floats:
        """Return unit normals at the nodes, (..., n, 2), outward if the area is positive."""
        tangent = self._tangent @ nodes
        length = np.hypot(tangent[..., 0], tangent[..., 1])
        normal = np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)
        return np.asarray(normal / np.maximum(length, 1e-12)[..., None])

    def area(self, nodes: Floats) -> Floats:
        """Return areas, (...) [px^2], half of x dy - y dx: positive if the nodes turn from u to
        v.
        """
        x, d = self._value @ nodes, self._slope @ nodes
        return np.asarray((x[..., 0] * d[..., 1] - x[..., 1] * d[..., 0]) @ self._weight / 2)

    def center(self, nodes: Floats) -> Floats:
        """Return the centroids of the areas, (..., 2) [px], NaN for an empty one; see centroid."""
        return np.concatenate(self._moments(nodes)[-2:], axis=-1)

    def centroid(self, nodes: Floats) -> tuple[Floats, Floats]:
        """Return the centroids of the areas, (..., 2) [px], and their derivatives by the nodes.

        By Green's theorem, the moments are integrals along the curve. If the curve moves by (dx,
        dy), the integral of f over the area changes by that of f (dx y' - dy x') along the curve.

        :return: centroids, and derivatives, (..., 2, n, 2), by u and v of each node.
        """
        x, y, dx, dy, safe, u, v = self._moments(nodes)
        arm = np.stack([x - u, y - v], axis=-2) / safe[..., None]
        change = np.stack([arm * dy[..., None, :], -arm * dx[..., None, :]], axis=-2)
        by_node = change @ self._value
        return np.concatenate([u, v], axis=-1), np.asarray(by_node.swapaxes(-2, -1))

    def _moments(self, nodes: Floats) -> tuple[Floats, ...]:
        """Return x, y, and their steps at the Gauss points, (..., m); area and centroid, (...,
        1).
        """
        x, y = (nodes[..., k] @ self._value.T for k in (0, 1))
        dx, dy = (nodes[..., k] @ self._slope.T * self._weight for k in (0, 1))
        area = (x * dy - y * dx).sum(axis=-1) / 2
        safe = np.where(np.abs(area) < 1e-9, np.nan, area)[..., None]
        u = (x * x * dy).sum(axis=-1)[..., None] / (2 * safe)
        v = -(y * y * dx).sum(axis=-1)[..., None] / (2 * safe)
        return x, y, dx, dy, safe, u, v


def _values(count: int, t: Floats) -> Floats:
    """Return the matrix, (n len(t), n), from control points to points at t on each segment."""
    return _circulant(count, np.stack([(1 - t) ** 2 / 2, 0.5 + t - t * t, t * t / 2]))


def _slopes(count: int, t: Floats) -> Floats:
    """Return the matrix, (n len(t), n), from control points to derivatives by t."""
    return _circulant(count, np.stack([t - 1, 1 - 2 * t, t]))


def _circulant(count: int, three: Floats) -> Floats:
    """Return rows with weights, (3, k), at the control points before, of, and after each
    segment.
    """
    rows = np.zeros((count, three.shape[1], count))
    i = np.arange(count)
    for offset, weight in zip((-1, 0, 1), three, strict=True):
        rows[i, :, (i + offset) % count] += weight
    return rows.reshape(-1, count)
