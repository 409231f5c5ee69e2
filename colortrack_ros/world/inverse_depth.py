"""Inverse-depth coordinates (X/Z, Y/Z, 1/Z) of positions in the optical frame (Civera et al. 2008).

Pixels and planes are linear in them, and a camera tilt shifts them by nearly the same amount at
every range; in meters, the shift grows with the square of the range. So the covariance of a
position that an update moves keeps the right dependence on the errors of the camera pose. Kept in
meters, that part would seem to be measured away.
"""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import POSITION


def from_points(optical: Pose, points: Floats) -> tuple[Floats, Floats]:
    """Return the coordinates of points, (N, 3), and their Jacobian, (N, 3, 3).

    :param optical: pose of the optical frame.
    :param points: (N, 3) in front of the camera [m].
    """
    y = (points - optical.t) @ optical.R
    y[:, 2] = 1 / y[:, 2]
    y[:, :2] *= y[:, 2:]
    # d(X/Z) = (dX - X/Z dZ) / Z, d(1/Z) = -dZ / Z^2
    J = optical.R.T * [[1.0], [1.0], [0.0]] - y[:, :, None] * optical.R[:, 2]
    return y, J * y[:, 2, None, None]


def to_points(optical: Pose, y: Floats) -> tuple[Floats, Floats]:
    """Return the points of coordinates, (N, 3) [m], and their Jacobian, (N, 3, 3)."""
    depth = 1 / y[:, 2:]
    away = depth * (y[:, :2] @ optical.R[:, :2].T + optical.R[:, 2])
    J = np.empty((len(y), 3, 3))
    J[:, :, :2], J[:, :, 2] = optical.R[:, :2], -away
    return optical.t + away, J * depth[:, :, None]


def in_inverse_depth(objects: Motions, optical: Pose) -> Motions:
    """Return states with positions in inverse depth in an optical frame."""
    y, J = from_points(optical, objects.mean[..., POSITION].reshape(-1, 3))
    return _in_other_coordinates(objects, y, J)


def in_space(objects: Motions, optical: Pose) -> Motions:
    """Reverse :func:`in_inverse_depth`."""
    points, J = to_points(optical, objects.mean[..., POSITION].reshape(-1, 3))
    return _in_other_coordinates(objects, points, J)


def inverted(points: Floats) -> tuple[Floats, Floats]:
    """Return points divided by their squared length, (N, 3), and the Jacobian, (N, 3, 3).

    Like inverse depth along a ray, but finite in all directions. The function is its own inverse.

    :param points: (N, 3) from the camera [m], or inverted [1/m].
    """
    length2 = np.square(points).sum(axis=1)[:, None]
    y = points / length2
    return y, np.eye(3) / length2[:, None] - 2 * y[:, :, None] * y[:, None, :]


def in_inversion(objects: Motions, eye: Floats) -> Motions:
    """Return states with positions inverted about a camera, (3,) [m]."""
    return _in_other_coordinates(
        objects, *inverted((objects.mean[..., POSITION] - eye).reshape(-1, 3))
    )


def out_of_inversion(objects: Motions, eye: Floats) -> Motions:
    """Reverse :func:`in_inversion`."""
    points, J = inverted(objects.mean[..., POSITION].reshape(-1, 3))
    return _in_other_coordinates(objects, points + eye, J)


def _in_other_coordinates(objects: Motions, position: Floats, J: Floats) -> Motions:
    """Return states with positions in other coordinates.

    :param position: (2 N, 3), and J: (2 N, 3, 3) its Jacobian.
    """
    J = J.reshape(-1, 2, 3, 3)
    there = Motions(objects.whole.copy(), objects.probability)
    there.whole[..., POSITION, :] = J @ objects.whole[..., POSITION, :]
    there.cov[..., POSITION] = there.cov[..., POSITION] @ J.swapaxes(-1, -2).copy()
    there.mean[..., POSITION] = position.reshape(-1, 2, 3)
    return there
