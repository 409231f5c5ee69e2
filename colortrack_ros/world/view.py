"""Where the camera is when a picture is taken, and how errors of its place move what it sees."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.directions import directions_of
from colortrack_ros.world.directions import pixels_of
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose

Floats = NDArray[np.float64]

LOWEST = 0.02
"""Height of a camera above the ground [m] from which on the ground tells how far things are."""

STEP = 0.25
"""Of the differences that make a Jacobian [px]: of a turn, which hardly bends."""


@dataclass(frozen=True, eq=False)
class View:
    """The camera at the time of a picture.

    :param camera: its lens.
    :param base: pose of the robot in the fixed frame.
    :param mount: pose of the camera's body (x forward, z up) on the robot.
    """

    camera: CameraModel
    base: Pose
    mount: Pose

    @cached_property
    def optical(self) -> Pose:
        """Pose of the optical frame in the fixed frame."""
        return self.base @ self.mount @ OPTICAL

    @cached_property
    def tilts(self) -> Floats:
        """(3, 3) rotation vectors in the fixed frame, by columns, of 1 rad of roll, pitch, yaw.

        As fixed-axis angles add up, yaw turns about the z of the robot, pitch about a y that has
        been turned by yaw, roll about the axis of the camera.
        """
        forward = self.mount.R[:, 0]
        yaw = np.arctan2(forward[1], forward[0])
        axes = [forward, [-np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]]
        return np.asarray(self.base.R @ np.array(axes).T)

    def moved(self, pixels: Floats, since: 'View') -> tuple[Floats, Floats]:
        """Where in this picture is what stands where an earlier one shows it.

        It is taken to be on the ground, on which base_frame is, and above the horizon far away. Of
        what is above the ground, driving shifts the picture more; that is left to be its motion.

        :param pixels: (N, 2) in the earlier picture, or beside it.
        :param since: the camera then.
        :return: (N, 2), in this picture or beside it, and the Jacobian, (N, 2, 2).
        """
        around = pixels + STEP * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])[:, None]
        rays = directions_of(since.camera, around.reshape(-1, 2))
        rays = rays @ since.optical.R.T
        height = since.optical.t[2] - since.base.t[2]
        nearness = np.maximum(-rays[:, 2:] / height, 0.0) if height > LOWEST else 0.0
        rays = (rays + nearness * (since.optical.t - self.optical.t)) @ self.optical.R
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        moved = pixels_of(self.camera, rays).reshape(around.shape)
        J = np.stack([moved[1] - moved[2], moved[3] - moved[4]], axis=2) / (2 * STEP)
        return moved[0], J

    def to_optical(self, points: Floats, shift: Floats, tilt: Floats) -> tuple[Floats, Floats]:
        """Points in the optical frame of a camera that is not quite where it is said to be.

        :param points: (N, 3) in the fixed frame.
        :param shift: (N, 3) error of x, y, z of the mount [m].
        :param tilt: (N, 3) error of its roll, pitch, yaw [rad], small.
        :return: (N, 3), and the Jacobian by point, shift and tilt, (N, 3, 9).
        """
        d = points - self.optical.t - shift @ self.base.R.T
        # as matrices of cross products, q = R^T (1 - W + W^2 / 2) d
        axes = np.cross(np.eye(3), self.tilts.T[:, None])
        W = np.tensordot(tilt, axes, 1).swapaxes(1, 2)
        Wd = (W @ d[:, :, None])[:, :, 0]
        turned, again = (a @ axes for a in (d[:, None, None], Wd[:, None, None]))
        by_tilt = (again + turned @ W.swapaxes(1, 2)[:, None]) / 2 - turned
        back = self.optical.R.T @ (np.eye(3) - W + W @ W / 2)
        J = np.empty((len(points), 3, 9))
        J[:, :, :3] = back
        J[:, :, 3:6] = -back @ self.base.R
        J[:, :, 6:] = self.optical.R.T @ by_tilt[:, :, 0].swapaxes(1, 2)
        return (back @ d[:, :, None])[:, :, 0], J
