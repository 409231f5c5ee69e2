"""View: pose of the camera at the time of a picture, and the effect of its errors on pixels."""

from dataclasses import dataclass
from functools import cached_property
import math

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.directions import directions_of
from colortrack_ros.world.directions import pixels_of
from colortrack_ros.world.poses import NO_ROBOT
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.poses import TransformError

JUMP, FASTEST = 0.3, 20.0
"""Motion or turn [m], [rad], and speed [m/s], [rad/s], that both exceed these are a jump: no
wheeled robot is as fast."""

RECALIBRATED = 0.01
"""Change of a pixel's ray from one picture to the next [rad] beyond which the camera has been
calibrated anew. A lens that zooms by 10 times in 6 s at 30 Hz changes by less. Chosen."""

HARDLY_DRIVES = 0.02
"""Speed of a robot [m/s], [rad/s] below which it stands: poses from pictures are off by 1 mm within
0.06 s. Chosen."""

LEAST_LENGTH = 1e-9
"""Least length of a direction; it is 0 straight below the camera, or at the camera itself."""

LOWEST = 0.02
"""Least height of the camera above the ground [m] at which ground contact measures the range."""

CROSS_PRODUCTS = np.cross(np.eye(3), np.eye(3)[:, None]).swapaxes(1, 2)
"""Matrices of the cross product with each axis, (3, 3, 3)."""

TWICE_ACROSS = (
    np.einsum('iac,jcb->ijab', CROSS_PRODUCTS, CROSS_PRODUCTS)
    + np.einsum('jac,icb->ijab', CROSS_PRODUCTS, CROSS_PRODUCTS)
) / 2
"""Products of these, each pair in both orders on average, (3, 3, 3, 3)."""

BEHIND = 0.3
"""Angle from straight behind the camera [rad] within which a covariance in pixels is carried along
unchanged: straight behind, the Jacobian is infinite, and a position that its own velocity keeps
there grew its covariance without bound. Turning at 5 to 60 degrees/s for 4 s, standard deviations
reach 300 to 4,500 px with 0.3 rad, and 1,700 to 95,000 px with 0.1 rad. Chosen."""

STEP = 0.25
"""Step of the finite differences for a Jacobian [px]: of a rotation, which is almost linear."""


@dataclass(frozen=True, eq=False)
class View:
    """The camera at the time of a picture.

    :param camera: its lens.
    :param base: pose of the robot in the fixed frame.
    :param mount: pose of the camera's body (x forward, z up) on the robot.
    :param way: (6,) velocity of the robot in its own frame [m/s], [rad/s]; None if not known.
    """

    camera: CameraModel
    base: Pose
    mount: Pose
    way: Floats | None = None

    @cached_property
    def optical(self) -> Pose:
        """Pose of the optical frame in the fixed frame."""
        return self.base @ self.mount @ OPTICAL

    @cached_property
    def tilts(self) -> Floats:
        """(3, 3) rotation vectors in the fixed frame, by columns, for 1 rad of roll, pitch, yaw.

        They are about the axes of the camera itself: for a camera that looks down, the axes of
        fixed-axis angles coincide, and none of them describes its sideways tilt.
        """
        return np.asarray(self.base.R @ self.mount.R)

    @cached_property
    def parks(self) -> bool:
        """Whether the camera surely stands in the fixed frame."""
        if self.way is None:
            return self.base is NO_ROBOT
        return bool(np.abs(self.way).max() < HARDLY_DRIVES)

    @cached_property
    def moves(self) -> Floats:
        """(6,) velocity of the camera's pose in terms of its errors, whose tilts are against it."""
        if self.way is None:
            return np.zeros(6)
        along, turn = np.split(self.way, 2)
        return np.append(along - turn @ (CROSS_PRODUCTS @ self.mount.t), -turn @ self.mount.R)

    def way_since(self, last: 'View') -> tuple[float, float]:
        """Return how far the robot has moved [m] and turned [rad]."""
        return way_between(last.base, self.base)

    def shows(self, pixels: Floats, reach: Floats) -> Bools:
        """Whether any part of objects would be inside the picture, (N,).

        :param pixels: (N, 2) inside the picture or outside.
        :param reach: (N, 2, 2) extent of the objects to the low and the high side, by axis [px].
        """
        size = np.array([self.camera.width, self.camera.height]) - 0.5
        inside = (pixels + reach[:, 1] >= -0.5) & (pixels - reach[:, 0] <= size)
        return np.asarray(inside.all(axis=1))

    def nearness(self, pixels: Floats, feet: Floats) -> Floats:
        """Return the inverse distance of objects on the ground plane of base_frame, (N,) [1/m].

        It is 0 at or above the horizon, or for a camera on the ground itself.

        :param pixels: (N, 2) in the picture.
        :param feet: (N, 2) pixels where the same objects touch the ground, or appear to.
        """
        height = self.optical.t[2] - self.base.t[2]
        if height < LOWEST:
            return np.zeros(len(pixels))
        rays, below = (directions_of(self.camera, x) @ self.optical.R.T for x in (pixels, feet))
        level, along = (np.hypot(x[:, 0], x[:, 1]) for x in (rays, below))
        return np.asarray(
            np.maximum(-below[:, 2], 0.0) / height * level / np.maximum(along, LEAST_LENGTH)
        )

    def moved(
        self, pixels: Floats, since: 'View', nearness: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Map pixels of stationary objects from an earlier picture to this one.

        :param pixels: (N, 2) in the earlier picture, or outside.
        :param since: the view at that time.
        :param nearness: (N,) inverse distance of the objects from the camera at that time [1/m].
        :return: (N, 2) in this picture or outside, the Jacobian, (N, 2, 2), of 1 behind the
            camera, and the current nearness, (N,).
        """
        around = pixels + STEP * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])[:, None]
        rays = directions_of(since.camera, around.reshape(-1, 2)) @ since.optical.R.T
        way = np.tile(nearness, len(around))[:, None] * (since.optical.t - self.optical.t)
        rays = (rays + way) @ self.optical.R
        length = np.maximum(np.linalg.norm(rays, axis=1), LEAST_LENGTH)
        moved = pixels_of(self.camera, rays / length[:, None]).reshape(around.shape)
        J = np.stack([moved[1] - moved[2], moved[3] - moved[4]], axis=2) / (2 * STEP)
        length = length[: len(pixels)]
        J[rays[: len(pixels), 2] < -np.cos(BEHIND) * length] = np.eye(2)
        return moved[0], J, nearness / length

    def to_optical(self, points: Floats, shift: Floats, tilt: Floats) -> tuple[Floats, Floats]:
        """Transform points to the optical frame of a camera whose mount is slightly in error.

        :param points: (N, 3) in the fixed frame.
        :param shift: (N, 3) error of x, y, z of the mount [m].
        :param tilt: (N, 3) error of its roll, pitch, yaw [rad], small.
        :return: (N, 3), and the Jacobian by point, shift and tilt, (N, 3, 9).
        """
        d = points - self.optical.t - shift @ self.base.R.T
        if len(tilt) > 1 and np.count_nonzero(tilt == tilt[0]) == tilt.size:
            tilt = tilt[:1]
        # by the matrix W of the cross product with a tilt, in the frame of the camera's body, q =
        # R^T (1 - W + W^2 / 2) d, and its derivative by each tilt
        parts = np.empty((len(tilt), 4, 3, 3))
        second = (tilt @ TWICE_ACROSS.reshape(3, 27)).reshape(-1, 3, 3, 3)
        np.subtract(second, CROSS_PRODUCTS, out=parts[:, 1:])
        half = (parts[:, 1:] - CROSS_PRODUCTS) / 2
        parts[:, 0] = np.eye(3) + (tilt[:, None] @ half.reshape(-1, 3, 9)).reshape(-1, 3, 3)
        parts = OPTICAL.R.T @ parts @ self.tilts.T
        by = parts.reshape(len(tilt), 12, 3).swapaxes(1, 2)
        each = d.reshape(len(tilt), len(d) // max(len(tilt), 1), 3)
        turned = (each @ by).reshape(-1, 4, 3)
        J = np.empty((len(points), 3, 9))
        J[:, :, :3] = parts[:, 0]
        J[:, :, 3:6] = -parts[:, 0] @ self.base.R
        J[:, :, 6:] = turned[:, 1:].swapaxes(1, 2)
        return turned[:, 0].copy(), J


def way_between(one: Pose, other: Pose) -> tuple[float, float]:
    """Return the distance [m] and the angle [rad] between two poses."""
    # trace of the relative rotation
    trace = float(np.vdot(one.R, other.R))
    return math.dist(one.t, other.t), math.acos(min(max((trace - 1) / 2, -1.0), 1.0))


def jumped(moved: float, angle: float, dt: float) -> str:
    """Return why no robot moves [m] and turns [rad] this far in dt [s]; empty if it may."""
    if max(moved, angle) <= JUMP + FASTEST * dt:
        return ''
    way = f'{moved:.2f} m and {np.degrees(angle):.0f} degrees'
    return f'the robot has jumped by {way} in {dt:.3f} s'


class JumpWatch:
    """Refuses views that a robot cannot reach: odometry was reset, or the frame jumps."""

    def __init__(self) -> None:
        self._last: tuple[int, View] | None = None

    def checked(self, stamp: int, view: View) -> View:
        """Return the view of a picture if it is consistent with the last one.

        :param stamp: of the picture [ns]; one that is not later is not compared with the last.
        :raises TransformError: it is inconsistent.
        """
        last, self._last = self._last, (stamp, view)
        if last is not None and stamp > last[0]:
            dt = (stamp - last[0]) / NANOSECONDS
            if jump := jumped(*view.way_since(last[1]), dt):
                raise TransformError(jump)
        return view


class CalibrationWatch:
    """Notices cameras that are calibrated anew: what was learned with another lens is wrong."""

    def __init__(self) -> None:
        self._last: dict[int, CameraModel] = {}

    def see(self, camera: int, model: CameraModel) -> str:
        """Return what has changed since the last picture of a camera; empty if nothing has."""
        last, self._last[camera] = self._last.get(camera, model), model
        if model is last:
            return ''
        size = np.array([model.width, model.height])
        corners = size * np.array([[0, 0], [1, 0], [0, 1], [1, 1], [0.5, 0.5]])
        turned = np.linalg.norm(
            directions_of(model, corners) - directions_of(last, corners), axis=1
        )
        if (last.width, last.height) == (model.width, model.height) and (
            turned.max() <= RECALIBRATED
        ):
            return ''
        return 'the camera has been calibrated anew: objects restart'
