"""What is measured of an object in a picture, and what would be of a state: rays first.

The sphere of diameter D = 2 rho at q = (X, Y, Z) in the optical frame is seen as an ellipse, whose
center is the image of (X, Y, Z - rho^2/Z), from the dual conic of its outline, and which covers the
solid angle 2 pi (1 - sqrt(1 - rho^2/|q|^2)). What a lens does across a blob is taken as linear:
with strong distortion the center is off by up to 2 % of the blob's diameter.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Columns
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.state import DIAMETER
from colortrack_ros.world.state import EDGE
from colortrack_ros.world.state import HEIGHT
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import SCALE
from colortrack_ros.world.state import SHIFT
from colortrack_ros.world.state import SIZE
from colortrack_ros.world.state import TILT
from colortrack_ros.world.view import View

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

U, V, PLANE, BLOB, DEPTH = range(5)
"""The rows of a measurement: the ray's pixel u and v [px], the height above the plane that the
center is on [m], 0; the diameter of the blob [px]; the depth of the center [m]."""

RAY_AND_RANGES = [U, V, BLOB, DEPTH]

PLANE_SIGMA = 1e-3
"""Standard deviation [m] of the height on the plane, from picture to picture: what is off for good
is a bias. Small against the height's own standard deviation of 5 mm."""


@dataclass
class Measured(Columns):
    """What is measured of N objects in one picture.

    :ivar z: (N, 5) see U to DEPTH.
    :ivar R: (N, 5, 5) covariance.
    :ivar used: (N, 5) what of it there is.
    """

    z: Floats
    R: Floats
    used: Bools

    @classmethod
    def none(cls, count: int) -> 'Measured':
        """Nothing of so many objects."""
        used = np.zeros((count, 5), bool)
        return cls(np.zeros((count, 5)), np.repeat(np.eye(5)[None], count, axis=0), used)


def expected(
    view: View, mean: Floats, diameter: Floats, plane: Floats, sized: bool = True
) -> tuple[Floats, Floats]:
    """What would be measured of states, (N, 5), and the Jacobian, (N, 5, 16).

    NaN for what the camera does not see.

    :param mean: (N, 16).
    :param diameter: (N,) [m], 0 where not known.
    :param plane: (N,) height of the center when on the ground, in the fixed frame [m].
    :param sized: whether sizes are asked for; 0 if not.
    """
    z, H = np.zeros((len(mean), 5)), np.zeros((len(mean), 5, SIZE))
    q, by_state = view.to_optical(mean[:, POSITION], mean[:, SHIFT], mean[:, TILT])
    known = diameter > 0
    rho = np.where(known, (diameter + mean[:, DIAMETER]) / 2, 0.0)
    with np.errstate(divide='ignore', invalid='ignore'):
        q[q[:, 2] <= rho] = np.nan  # beside or behind the camera, or around it
        flat = rho / q[:, 2]
        middle = q.copy()
        middle[:, 2] -= rho * flat
        z[:, :2], J = view.camera.linearized(middle)
        by_q = np.zeros((len(mean), 4, 3))
        by_q[:, :2] = J
        by_q[:, :2, 2] *= (1 + flat * flat)[:, None]
        H[:, :2, DIAMETER] = -J[:, :, 2] * flat[:, None] * known[:, None]
        if sized:
            size, by_q[:, 2] = _blob(q, middle, J, rho)
            H[:, BLOB, DIAMETER] = np.where(known, size / (2 * rho), 0.0)
            z[:, BLOB], H[:, BLOB, EDGE] = size + mean[:, EDGE], 1.0
    scale = 1 + mean[:, SCALE]
    z[:, DEPTH], H[:, DEPTH, SCALE] = q[:, 2] * scale, q[:, 2]
    by_q[:, 3, 2] = scale
    by_state = by_q @ by_state
    H[:, RAY_AND_RANGES, POSITION] = by_state[:, :, :3]
    H[:, RAY_AND_RANGES, SHIFT.start : TILT.stop] = by_state[:, :, 3:]
    z[:, PLANE] = mean[:, 2] - plane - mean[:, HEIGHT]
    H[:, PLANE, 2], H[:, PLANE, HEIGHT] = 1.0, -1.0
    return z, H


def _blob(q: Floats, middle: Floats, J: Floats, rho: Floats) -> tuple[Floats, Floats]:
    """The diameter of the disc of the blob's area [px], (N,), and its Jacobian by q, (N, 3).

    The magnification of the lens, in pixels a steradian, is taken at the blob's center, and for the
    Jacobian as constant.
    """
    length2 = np.square(q).sum(axis=1)
    cosine = np.sqrt(1 - np.minimum(rho * rho / length2, 1.0))
    JJ = J @ J.swapaxes(1, 2)
    magnification = np.sqrt(JJ[:, 0, 0] * JJ[:, 1, 1] - JJ[:, 0, 1] ** 2)
    magnification *= np.square(middle).sum(axis=1)
    size = np.sqrt(8 * (1 - cosine) * magnification)
    return size, -size[:, None] * q / length2[:, None]


def ranges_by_size(camera: CameraModel, rays: Floats, size: Floats, diameter: Floats) -> Floats:
    """The distance of spheres, (N,) [m], of the diameter of their blobs [px]; see :func:`expected`.

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
    """Where measured objects are, (N, 3), by the first of depth, ground and size; NaN for nowhere.

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
