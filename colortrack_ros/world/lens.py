"""Lens: the distortion models of sensor_msgs/CameraInfo.

A lens maps directions in the optical frame (x right, y down, z forward) to points in the plane that
the camera matrix K maps to pixels. With Z = 1 and no distortion, x = X/Z and y = Y/Z.
"""

from abc import ABC
from abc import abstractmethod

import numpy as np

from colortrack_ros.data import Floats

ITERATIONS = 20
"""Maximum number of Newton steps. From the distorted point, 5 reach 1e-12 for the lenses of the
tests."""

CONVERGED = 1e-9
"""Largest error of an inverted distortion [focal lengths]: 1e-6 px at f = 1000 px."""

WIDEST = 5.0
"""Largest radius at which a planar lens model is evaluated [focal lengths]: 79 degrees off its
axis."""

SAMPLES = 2000
"""Number of radii at which the monotonicity of a lens is checked; a step is 0.1 degrees or less."""


FIRST = np.eye(12)[0]
"""Unit vector of the coefficient k1."""


class Lens(ABC):
    """The interface of a distortion model.

    :param coefficients: D of CameraInfo.
    :cvar counts: allowed numbers of coefficients.
    """

    counts: tuple[int, ...]

    @abstractmethod
    def __init__(self, coefficients: Floats) -> None: ...

    @abstractmethod
    def distort(self, points: Floats) -> tuple[Floats, Floats]:
        """Return the image points of points in space, and their Jacobian.

        :param points: (N, 3) in the optical frame, of any length.
        :return: (N, 2) and the Jacobian, (N, 2, 3); NaN if the lens does not see the point.
        """

    @abstractmethod
    def undistort(self, seen: Floats) -> Floats:
        """Return the directions of image points.

        :param seen: (N, 2).
        :return: (N, 3) unit vectors; NaN if there is no such direction.
        """

    @abstractmethod
    def bent(self, by: float) -> 'Lens':
        """Return the lens with its first radial coefficient, k1, increased by an amount."""


class BrownConrady(Lens):
    """plumb_bob and rational_polynomial: radial, tangential and thin prism distortion.

    With r^2 = x^2 + y^2 (OpenCV, calib3d, of coefficients k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4)::

        g  = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
        x' = x g + 2 p1 x y + p2 (r^2 + 2 x^2) + s1 r^2 + s2 r^4
        y' = y g + p1 (r^2 + 2 y^2) + 2 p2 x y + s3 r^2 + s4 r^4

    Two more, of a tilted sensor, have to be 0. Beyond the radius at which r g stops growing, the
    polynomial folds back: nothing is seen there.
    """

    counts = (0, 4, 5, 8, 12, 14)

    def __init__(self, coefficients: Floats) -> None:
        self._all = c = np.zeros(12)
        c[: len(coefficients)] = coefficients[:12]
        self._p = c[2:4]
        self._above = np.array([1.0, c[0], c[1], c[4]])
        self._below = np.array([1.0, c[5], c[6], c[7]])
        self._prism = c[8:].reshape(2, 2)
        self._divides, self._has_prism = c[5:8].any(), c[8:].any()
        r = np.linspace(0, WIDEST, SAMPLES)
        g, slope = self._radial(r * r)
        folded = g + 2 * r * r * slope <= 0
        self._limit = r[folded.argmax()] ** 2 if folded.any() else np.inf

    def distort(self, points: Floats) -> tuple[Floats, Floats]:
        """See :meth:`Lens.distort`."""
        with np.errstate(divide='ignore', invalid='ignore'):
            depth = np.where(points[:, 2] > 0, points[:, 2], np.nan)
            flat = points[:, :2] / depth[:, None]
        r2 = _squared(flat)
        unseen = r2 > self._limit
        flat[unseen], r2[unseen] = np.nan, np.nan
        seen, J = self._distort_flat(flat, r2)
        # d(X/Z)/dX = 1/Z, d(X/Z)/dZ = -(X/Z)/Z
        to_flat = np.zeros((len(points), 2, 3))
        to_flat[:, 0, 0] = to_flat[:, 1, 1] = 1
        to_flat[:, :, 2] = -flat
        return seen, J @ to_flat / depth[:, None, None]

    def undistort(self, seen: Floats) -> Floats:
        """See :meth:`Lens.undistort`; by Newton steps."""
        seen = np.asfortranarray(seen)  # NumPy then loops over the points, not over two coordinates
        # strong barrel distortion may only be defined within the limit: start inside it
        radius = np.sqrt(np.square(seen).sum(axis=1) / self._limit)
        flat = seen / np.maximum(1, radius)[:, None]
        error = np.full(len(seen), np.inf)
        with np.errstate(all='ignore'):
            for _ in range(ITERATIONS):
                again, J = self._distort_flat(flat, _squared(flat))
                rest = again - seen
                error = np.abs(rest).max(axis=1, initial=0.0)
                if np.all((error < CONVERGED) | ~np.isfinite(error)):
                    break
                det = J[:, 0, 0] * J[:, 1, 1] - J[:, 0, 1] * J[:, 1, 0]
                step_x = (J[:, 1, 1] * rest[:, 0] - J[:, 0, 1] * rest[:, 1]) / det
                step_y = (J[:, 0, 0] * rest[:, 1] - J[:, 1, 0] * rest[:, 0]) / det
                flat = flat - np.stack([step_x, step_y]).T
            lost = ~(error < CONVERGED) | (np.square(flat).sum(axis=1) > self._limit)
        flat[lost] = np.nan
        rays = np.concatenate([flat, np.ones((len(flat), 1))], axis=1)
        return np.ascontiguousarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))

    def bent(self, by: float) -> Lens:
        """See :meth:`Lens.bent`."""
        return type(self)(self._all + by * FIRST[: self._all.size])

    def _radial(self, r2: Floats) -> tuple[Floats, Floats]:
        """Return g and its derivative by r^2."""
        above = _polynomial(self._above, r2)
        if not self._divides:
            return above
        below = _polynomial(self._below, r2)
        g = above[0] / below[0]
        return g, (above[1] - g * below[1]) / below[0]

    def _distort_flat(self, flat: Floats, r2: Floats) -> tuple[Floats, Floats]:
        """Return the points x', y', (N, 2), and their Jacobian by x and y, (N, 2, 2).

        :param r2: (N,) squared lengths of the points.
        """
        g, slope = self._radial(r2)
        cross = flat[:, 0] * flat[:, 1]
        p = self._p[::-1]  # x' takes p2, y' takes p1, with their own squares
        seen = flat * g[:, None] + 2 * self._p * cross[:, None]
        seen += p * (r2[:, None] + 2 * flat * flat)
        # d r^2 = 2 x dx + 2 y dy
        by_r2 = flat * slope[:, None] + p
        if self._has_prism:
            seen += r2[:, None] * self._prism[:, 0] + (r2 * r2)[:, None] * self._prism[:, 1]
            by_r2 += self._prism[:, 0] + 2 * r2[:, None] * self._prism[:, 1]
        J = 2 * by_r2[:, :, None] * flat[:, None, :]
        J += 2 * self._p[:, None] * flat[:, None, ::-1]
        along = np.einsum('nii->ni', J)  # a view
        along += g[:, None] + 4 * p * flat
        return seen, J


class Equidistant(Lens):
    """equidistant: Kannala-Brandt, for fisheye lenses.

    With theta the angle off the optical axis (OpenCV, calib3d fisheye)::

        theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)

    It sees beyond 90 degrees, as far as theta_d grows.
    """

    counts = (4,)

    def __init__(self, coefficients: Floats) -> None:
        self._k = np.concatenate([[1.0], coefficients])
        theta = np.linspace(0, np.pi, SAMPLES)
        falling = self._bent(theta)[1] <= 0
        self._limit = theta[falling.argmax()] if falling.any() else np.pi

    def distort(self, points: Floats) -> tuple[Floats, Floats]:
        """See :meth:`Lens.distort`."""
        r = np.hypot(points[:, 0], points[:, 1])
        theta = np.arctan2(r, points[:, 2].copy())
        theta[theta > self._limit] = np.nan
        bent, slope = self._bent(theta)
        length2 = r * r + np.square(points[:, 2])
        with np.errstate(divide='ignore', invalid='ignore'):
            side = points[:, :2] / r[:, None]
            scale = bent / r
        axis = r < CONVERGED * np.abs(points[:, 2])  # theta_d / r = 1 / Z on the axis
        side[axis] = 0.0
        scale[axis] = 1 / np.where(points[axis, 2] > 0, points[axis, 2], np.nan)
        # theta by the point: cos(theta)/length along the side, -sin(theta)/length along z
        by_theta = np.empty((len(points), 3))
        by_theta[:, :2] = side * (points[:, 2] / length2)[:, None]
        by_theta[:, 2] = -r / length2
        J = np.zeros((len(points), 2, 3))
        J[:, :, :2] = scale[:, None, None] * (np.eye(2) - side[:, :, None] * side[:, None, :])
        J += (side * slope[:, None])[:, :, None] * by_theta[:, None, :]
        return points[:, :2] * scale[:, None], J

    def undistort(self, seen: Floats) -> Floats:
        """See :meth:`Lens.undistort`; by Newton steps."""
        bent = np.hypot(seen[:, 0], seen[:, 1])
        theta = np.minimum(bent, self._limit)
        with np.errstate(all='ignore'):
            for _ in range(ITERATIONS):
                value, slope = self._bent(theta)
                theta = np.clip(theta - (value - bent) / slope, 0.0, self._limit)
            lost = ~(np.abs(self._bent(theta)[0] - bent) < CONVERGED)
            side = np.where(bent[:, None] > 0, seen / bent[:, None], 0.0)
        theta[lost] = np.nan
        return np.concatenate([side * np.sin(theta)[:, None], np.cos(theta)[:, None]], axis=1)

    def bent(self, by: float) -> Lens:
        """See :meth:`Lens.bent`."""
        return type(self)(self._k[1:] + by * FIRST[: self._k.size - 1])

    def _bent(self, theta: Floats) -> tuple[Floats, Floats]:
        """Return theta_d and its derivative by theta."""
        value, slope = _polynomial(self._k, theta * theta)
        return theta * value, value + 2 * theta * theta * slope


LENSES: dict[str, type[Lens]] = {
    'plumb_bob': BrownConrady,
    'rational_polynomial': BrownConrady,
    'equidistant': Equidistant,
}
"""Lens classes by the distortion_model of CameraInfo (sensor_msgs/distortion_models.hpp). As in
image_geometry, the number of coefficients tells the first two apart: drivers mix up the names."""


def _squared(flat: Floats) -> Floats:
    """Return the squared lengths of points in a plane, (N, 2)."""
    return flat[:, 0] * flat[:, 0] + flat[:, 1] * flat[:, 1]


def _polynomial(coefficients: Floats, x: Floats) -> tuple[Floats, Floats]:
    """Return the value of a polynomial, lowest power first, and its derivative."""
    value, slope = np.full_like(x, coefficients[-1]), np.zeros_like(x)
    for c in coefficients[-2::-1]:
        slope = slope * x + value
        value = value * x + c
    return value, slope
