"""Positions as a camera sees them: (X/Z, Y/Z, 1/Z) in its optical frame (Civera et al. 2008).

What a pixel and a plane say is linear in them, and a tilt of the camera shifts them by nearly as
much at every range; in meters, the shift grows with the square of the range. So when an update
moves a position, its covariance, carried over in these coordinates, stays the one that the errors
of the camera's place have there. Kept in meters it would seem to be measured away.
"""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.world.poses import Pose

Floats = NDArray[np.float64]


def from_points(optical: Pose, points: Floats) -> tuple[Floats, Floats]:
    """The coordinates of points, (N, 3), and their Jacobian, (N, 3, 3).

    :param optical: pose of the optical frame.
    :param points: (N, 3) in front of the camera [m].
    """
    q = (points - optical.t) @ optical.R
    y = np.concatenate([q[:, :2], np.ones((len(q), 1))], axis=1) / q[:, 2:]
    J = np.zeros((len(q), 3, 3))
    J[:, 0, 0] = J[:, 1, 1] = 1.0
    J[:, :, 2] = -y
    J[:, 2, 2] = -y[:, 2]
    return y, J @ optical.R.T / q[:, 2:, None]


def to_points(optical: Pose, y: Floats) -> tuple[Floats, Floats]:
    """The points of coordinates, (N, 3) [m], and their Jacobian, (N, 3, 3)."""
    depth = 1 / y[:, 2:]
    q = np.concatenate([y[:, :2], np.ones((len(y), 1))], axis=1) * depth
    J = np.zeros((len(y), 3, 3))
    J[:, 0, 0] = J[:, 1, 1] = 1.0
    J[:, :, 2] = -q
    return optical.apply(q), optical.R @ (J * depth[:, :, None])
