"""The mistakes that are made where a camera is mounted on a robot, each with what is told of it."""

from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose

Floats = NDArray[np.float64]

SIDEWAYS, UPSIDE = np.diag([1.0, -1.0, 1.0]), np.diag([1.0, 1.0, -1.0])
"""Mirrors of left and right, and of up and down, which turn the signs of yaw and of pitch."""

T = TypeVar('T')


def as_given(what: T) -> T:
    """What it is."""
    return what


@dataclass(frozen=True)
class Mistake:
    """How things would be if it had been made; of what is not named, as given.

    :ivar mount, base: of the poses of the camera on the robot and of the robot, of V pictures at
        once: t (V, 3), R (V, 3, 3).
    :ivar camera: of the lens.
    """

    mount: Callable[[Pose], Pose] = as_given
    base: Callable[[Pose], Pose] = as_given
    camera: Callable[[CameraModel], CameraModel] = as_given


def _scaled(share: float) -> Mistake:
    """With a camera matrix of a picture so many times as large."""
    return Mistake(camera=lambda camera: replace(camera, K=np.diag([share, share, 1.0]) @ camera.K))


def _rolled(degrees: float) -> Mistake:
    own = Pose.of_rpy(np.zeros(3), (np.radians(degrees), 0, 0))
    return Mistake(lambda mount: mount @ own)


def _yawed(degrees: float) -> Mistake:
    turn = Pose.of_rpy(np.zeros(3), (0, 0, np.radians(degrees))).R
    return Mistake(lambda mount: Pose(mount.t, turn @ mount.R))


def pitched(degrees: float) -> Mistake:
    """With a camera that looks down by so many degrees more."""
    own = Pose.of_rpy(np.zeros(3), (0, np.radians(degrees), 0))
    return Mistake(lambda mount: mount @ own)


def _mirrored(pose: Pose, mirror: Floats) -> Pose:
    """Its rotation as a mirror shows it, (3, 3) diagonal."""
    return Pose(pose.t, mirror @ pose.R @ mirror)


MISTAKES: dict[str, Mistake] = {
    'camera_pose has roll 0 for a camera that is upside down, or pi for one that is not': (
        _rolled(180)
    ),
    'the camera lies on its side, and camera_pose has roll off by pi/2': _rolled(90),
    'the camera lies on its side, and camera_pose has roll off by -pi/2': _rolled(-90),
    'the pitch of camera_pose has the wrong sign: positive looks down': Mistake(
        lambda mount: _mirrored(mount, UPSIDE)
    ),
    'the camera looks backward: the yaw of camera_pose is off by pi': _yawed(180),
    'the yaw of camera_pose is off by pi/2: positive looks left': _yawed(90),
    'the yaw of camera_pose is off by -pi/2: positive looks left': _yawed(-90),
    'camera_pose is of the optical frame, expected of the body, x forward, z up': Mistake(
        lambda mount: mount @ OPTICAL.inverse()
    ),
    'the frame of the pictures is the body of the camera, expected the optical frame': Mistake(
        lambda mount: mount @ OPTICAL
    ),
    'the height of the camera has the wrong sign': Mistake(
        lambda mount: Pose(mount.t * [1, 1, -1], mount.R)
    ),
    'the calibration is of pictures half as large': _scaled(2.0),
    'the calibration is of pictures twice as large': _scaled(0.5),
    'odometry goes backward where the robot drives forward': Mistake(
        base=lambda base: Pose(-base.t, base.R)
    ),
    'odometry turns right where the robot turns left': Mistake(
        base=lambda base: _mirrored(Pose(base.t * [1, -1, 1], base.R), SIDEWAYS)
    ),
}
"""What is told of each, and what would mend it."""

AS_GIVEN = Mistake()

OF_ABOUT = ' is off by about '
"""Between what is off and by how much."""

FINE = 9
"""Angles that are looked at between those of a coarse look beside its best: 2 to 7 degrees apart.
Chosen."""


@dataclass(frozen=True)
class WrongAngle:
    """A camera that is turned otherwise than camera_pose says.

    :ivar about: the name of the angle; of: what would mend it, by degrees.
    :ivar angles: (V,) ascending, by which it is off [degrees], at which it is looked at first.
    :ivar angle: this one.
    """

    about: str
    of: Callable[[float], Mistake]
    angles: tuple[float, ...]
    angle: float = 0.0

    @property
    def line(self) -> str:
        """What is told."""
        return f'the {self.about} of camera_pose{OF_ABOUT}{self.angle:.0f} degrees'

    @property
    def mistake(self) -> Mistake:
        """What would mend it."""
        return self.of(-self.angle)

    def coarse(self) -> list['WrongAngle']:
        """By all of the angles."""
        return [replace(self, angle=angle) for angle in self.angles]

    def around(self) -> list['WrongAngle']:
        """By angles near this one, that are not so small that they are no mistake."""
        at, least = self.angles.index(self.angle), min(map(abs, self.angles))
        low, high = self.angles[max(at - 1, 0)], self.angles[min(at + 1, len(self.angles) - 1)]
        fine = np.linspace(low, high, FINE)
        return [replace(self, angle=float(angle)) for angle in fine[np.abs(fine) >= least]]


def _both_ways(*angles: float) -> tuple[float, ...]:
    return *(-angle for angle in angles[::-1]), *angles


WRONG_ANGLES = (
    WrongAngle('yaw', _yawed, _both_ways(10, 20, 30, 45, 60, 75, 105, 120, 135, 150, 165)),
    WrongAngle('roll', _rolled, _both_ways(10, 20, 30, 45, 60, 75)),
    WrongAngle('pitch', pitched, _both_ways(6, 12, 20, 30, 45)),
)
"""Smaller ones are hardly told from errors that are expected. Chosen."""
