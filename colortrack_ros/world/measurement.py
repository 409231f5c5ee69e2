"""Measurement model: what a picture measures of an object, and its prediction from a state.

The sphere of diameter D = 2 rho at q = (X, Y, Z) in the optical frame is seen as an ellipse. From
the dual conic of its outline, the center is the image of (X, Y, Z - rho^2/Z); the ellipse covers
the solid angle 2 pi (1 - sqrt(1 - rho^2/|q|^2)). The lens is linearized across a blob: with strong
distortion, the center is off by up to 2 % of the blob's diameter.
"""

from dataclasses import dataclass
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.state import DIAMETER
from colortrack_ros.world.state import EDGE
from colortrack_ros.world.state import HEIGHT
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import OF_CAMERA
from colortrack_ros.world.state import OF_MOUNT
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import SCALE
from colortrack_ros.world.state import SHIFT
from colortrack_ros.world.state import SIZE
from colortrack_ros.world.state import TILT
from colortrack_ros.world.state import time_of
from colortrack_ros.world.state import VELOCITY
from colortrack_ros.world.view import View

U, V, PLANE, BLOB, DEPTH = range(5)
"""Rows of a measurement: pixel u and v of the ray [px], height above the plane of the center [m],
measured as 0, diameter of the blob [px], and depth of the center [m]."""

PLANE_SIGMA = 1e-3
"""Standard deviation [m] of the height above the plane, independent by picture; constant errors are
biases. Small against the height's own standard deviation of 5 mm."""


LASTS, SHORTEST = 1.0, 1e-3
"""Time constant of errors that last, and least time between pictures [s]. Centers of the boxes of
people in KITTI tracking 0016 are correlated by 0.9 after 0.1 s, 0.74 after 0.3 s and 0.3 after 1 s,
those of a simulated ball that a pillar covers by degrees by 0.5 after 0.2 s and 0.2 after 0.5 s.
The other is that of any camera."""


@dataclass
class Measured(Columns):
    """Measurements of N objects in one picture.

    :ivar z: (N, 5), see U to DEPTH.
    :ivar R: (N, 5, 5) covariance, as if there were no other picture.
    :ivar used: (N, 5) which rows are measured.
    :ivar lasting: (N, 5) the part of the variances in R that is of errors that last.
    """

    z: Floats
    R: Floats
    used: Bools
    lasting: Floats

    @classmethod
    def none(cls, count: int) -> 'Measured':
        """Return empty measurements of count objects."""
        used = np.zeros((count, 5), bool)
        R = np.repeat(np.eye(5)[None], count, axis=0)
        return cls(np.zeros((count, 5)), R, used, np.zeros((count, 5)))

    def after(self, dt: Floats) -> 'Measured':
        """Return what these tell beside measurements that were made some time before, (N,) [s].

        Errors with autocorrelation rho = exp(-dt / LASTS) tell as much of what is constant as
        independent ones with (1 + rho) / (1 - rho) times the variance (Bartlett 1935). With the
        first at its own variance, that is exact for any number of them.
        """
        if not np.count_nonzero(self.lasting):
            return self
        more = 1 / np.tanh(np.maximum(dt, SHORTEST) / (2 * LASTS)) - 1
        R, each = self.R.copy(), np.arange(5)
        R[:, each, each] += more[:, None] * self.lasting
        return replace(self, R=R)

    def aligned(self, found: NDArray[np.integer], own: NDArray[np.integer]) -> 'Measured':
        """Return the measurements of objects, empty ones for those that are not measured.

        :param found: (N,) IDs of what is measured; own: (K,) IDs of the objects.
        """
        if len(own) == len(found) and np.count_nonzero(own == found) == len(own):
            return self
        aligned = Measured.none(len(own))
        rows, which = (own[:, None] == found).nonzero()
        aligned.put(rows, self.take(which))
        return aligned


def two_ranges(measured: Measured) -> Bools:
    """Return which objects, (N,), have a range by the ground and another one."""
    used = measured.used
    return np.asarray(used[:, PLANE] & (used[:, BLOB] | used[:, DEPTH]))


def expected(
    view: View, mean: Floats, diameter: Floats, plane: Floats, sized: bool = True
) -> tuple[Floats, Floats]:
    """Return the predicted measurements of states, (N, 5), and the Jacobian, (N, 5, 16).

    NaN for objects outside the camera's view.

    :param mean: (N, 16).
    :param diameter: (N,) [m], 0 if unknown.
    :param plane: (N,) height of the center when on the ground, in the fixed frame [m].
    :param sized: whether to predict blob sizes; 0 if not.
    """
    z, H = np.zeros((len(mean), 5)), np.zeros((len(mean), 5, SIZE))
    q, by_state = view.to_optical(mean[:, POSITION], mean[:, SHIFT], mean[:, TILT])
    known = diameter > 0
    rho = np.where(known, (diameter + mean[:, DIAMETER]) / 2, 0.0)
    with np.errstate(divide='ignore', invalid='ignore'):
        q[q[:, 2] <= rho] = np.nan  # beside, behind, or around the camera
        flat = rho / q[:, 2]
        middle = q.copy()
        middle[:, 2] -= rho * flat
        z[:, :2], J = view.camera.linearized(middle)
        by_q = np.zeros((len(mean), 5, 3))
        by_q[:, :2] = J
        by_q[:, :2, 2] *= (1 + flat * flat)[:, None]
        H[:, :2, DIAMETER] = -J[:, :, 2] * flat[:, None] * known[:, None]
        if sized:
            size, by_q[:, BLOB] = _blob(q, middle, J, rho)
            H[:, BLOB, DIAMETER] = np.where(known, size / (2 * rho), 0.0)
            z[:, BLOB], H[:, BLOB, EDGE] = size + mean[:, EDGE], 1.0
    scale = 1 + mean[:, SCALE]
    z[:, DEPTH], H[:, DEPTH, SCALE] = q[:, 2] * scale, q[:, 2]
    by_q[:, DEPTH, 2] = scale
    by_state = by_q @ by_state
    H[:, :, POSITION], H[:, :, SHIFT.start : TILT.stop] = by_state[:, :, :3], by_state[:, :, 3:]
    z[:, PLANE] = mean[:, 2] - plane - mean[:, HEIGHT]
    H[:, PLANE], H[:, PLANE, 2], H[:, PLANE, HEIGHT] = 0.0, 1.0, -1.0
    return z, H


def predicted(
    view: View,
    state: Floats,
    errors: Floats,
    kinds: Kinds,
    ground: float,
    camera: int = 0,
    sized: bool = True,
) -> tuple[Floats, Floats]:
    """Return what a camera measures of states at its errors; see :func:`expected`.

    Objects are where the first camera sees them at its stamps. If those of another one are farther
    apart from odometry, it sees them when they have moved on. How far the first ones are apart is
    told by the robot's own motion only, so that velocities, not known at first, say nothing of it.

    :param state: (N, 8); errors: (N, 9 C) of all cameras.
    :return: the Jacobian by the states, (N, 5, 8), and the one by the errors beside the measured
        values, (N, 5, 9 C + 1).
    """
    own, count = slice(OF_CAMERA * camera, OF_CAMERA * (camera + 1)), errors.shape[1]
    mean = np.concatenate([state, errors[:, own]], axis=1)
    if view.way is not None:
        time = time_of(camera, count)
        mean[:, OF_MOUNT] += errors[:, time, None] * view.moves
        if camera:
            apart = errors[:, time, None] - errors[:, time - camera, None]
            mean[:, POSITION] += apart * mean[:, VELOCITY]
    z, H = expected(view, mean, kinds.diameter, ground + kinds.height, sized)
    rest = np.zeros((len(z), 5, count + 1))
    rest[:, :, own], rest[:, :, -1] = H[:, :, OF_OBJECT:], z
    if view.way is not None:
        rest[:, :, time] = H[:, :, OF_MOUNT] @ view.moves
        if camera:
            moved = (H[:, :, POSITION] @ mean[:, VELOCITY, None])[..., 0]
            rest[:, :, time] += moved
            rest[:, :, time - camera] -= moved
            H[:, :, VELOCITY] += apart[:, :, None] * H[:, :, POSITION]
    return H[:, :, :OF_OBJECT], rest


def _blob(q: Floats, middle: Floats, J: Floats, rho: Floats) -> tuple[Floats, Floats]:
    """Return the diameter of the disc of the blob's area [px], (N,), and its Jacobian by q.

    The Jacobian, (N, 3), takes the magnification of the lens, in pixels per steradian, as constant;
    it is that at the blob's center.
    """
    length2 = np.square(q).sum(axis=1)
    cosine = np.sqrt(1 - np.minimum(rho * rho / length2, 1.0))
    JJ = J @ J.swapaxes(1, 2)
    magnification = np.sqrt(JJ[:, 0, 0] * JJ[:, 1, 1] - JJ[:, 0, 1] ** 2)
    magnification *= np.square(middle).sum(axis=1)
    size = np.sqrt(8 * (1 - cosine) * magnification)
    return size, -size[:, None] * q / length2[:, None]


def ranges_by_size(camera: CameraModel, rays: Floats, size: Floats, diameter: Floats) -> Floats:
    """Return the distances of spheres, (N,) [m], by blob diameter [px]; see :func:`expected`.

    NaN where the lens shows nothing.

    :param rays: (N, 3) of the blobs' centers, optical.
    """
    J = camera.linearized(rays)[1]
    JJ = J @ J.swapaxes(1, 2)
    magnification = np.sqrt(JJ[:, 0, 0] * JJ[:, 1, 1] - JJ[:, 0, 1] ** 2)
    with np.errstate(divide='ignore', invalid='ignore'):
        cosine = np.clip(1 - np.square(size) / (8 * magnification), 0.0, 1.0)
        return np.asarray(diameter / 2 / np.sqrt(1 - cosine * cosine))


def guesses(measured: Measured, kinds: Kinds, view: View, ground: float) -> Floats:
    """Return the positions of objects, (N, 3), by depth, ground or size, in this order.

    NaN where none is measured.

    :param ground: its height in the fixed frame [m].
    """
    rays = view.camera.rays(measured.z[:, :2])
    directions = rays @ view.optical.R.T
    height = ground + kinds.height - view.optical.t[2]
    with np.errstate(divide='ignore', invalid='ignore'):
        by_plane = height / directions[:, 2]
        by_depth = measured.z[:, DEPTH] / rays[:, 2]
    by_size = ranges_by_size(view.camera, rays, measured.z[:, BLOB], kinds.diameter)
    distance = np.select(
        [measured.used[:, DEPTH], measured.used[:, PLANE], measured.used[:, BLOB]],
        [by_depth, by_plane, by_size],
        np.nan,
    )
    distance[~(distance > 0)] = np.nan
    return np.asarray(view.optical.t + distance[:, None] * directions)
