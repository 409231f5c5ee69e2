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
    :ivar later: the pose of the robot is the one that was given so much later [s].
    """

    mount: Callable[[Pose], Pose] = as_given
    base: Callable[[Pose], Pose] = as_given
    camera: Callable[[CameraModel], CameraModel] = as_given
    later: float = 0.0


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

FINE = 16
"""Amounts that are looked at between those of a coarse look beside its best: 1 to 4 degrees apart,
2 % of a focal length, 13 to 20 ms. Chosen."""


LATEST = 0.4
"""How late odometry is looked at [s]: as much older than pictures poses are kept. Chosen."""


@dataclass(frozen=True)
class WrongAmount:
    """One number of how a robot is set up that is not as it is given.

    :ivar about: its name; unit: of the amounts.
    :ivar of: what would mend it, by the amount that is to be added.
    :ivar amounts: (V,) ascending, by which it is off, at which it is looked at first.
    :ivar amount: this one.
    """

    about: str
    unit: str
    of: Callable[[float], Mistake]
    amounts: tuple[float, ...]
    amount: float = 0.0

    @property
    def line(self) -> str:
        """What is told."""
        return f'{self.about}{OF_ABOUT}{self.amount:+.3g} {self.unit}'.rstrip()

    @property
    def mistake(self) -> Mistake:
        """What would mend it."""
        return self.of(-self.amount)

    def coarse(self) -> list['WrongAmount']:
        """By all of the amounts."""
        return [replace(self, amount=amount) for amount in self.amounts]

    def around(self) -> list['WrongAmount']:
        """By amounts near this one, that are not so small that they are no mistake."""
        at, least = self.amounts.index(self.amount), min(map(abs, self.amounts))
        low, high = self.amounts[max(at - 1, 0)], self.amounts[min(at + 1, len(self.amounts) - 1)]
        fine = np.append(np.linspace(low, high, FINE), self.amount)
        return [replace(self, amount=float(amount)) for amount in fine[np.abs(fine) >= least]]


def _both_ways(*amounts: float) -> tuple[float, ...]:
    return *(-amount for amount in amounts[::-1]), *amounts


def _without(percent: float) -> float:
    """By what a number is multiplied that has so many percent less added to it than it should."""
    return 1 / (1 - percent / 100)


def _moved(axis: int) -> Callable[[float], Mistake]:
    """With a camera that is elsewhere on the robot by meters."""
    return lambda meters: Mistake(lambda m: Pose(m.t + meters * np.eye(3)[axis], m.R))


def _raised(percent: float) -> Mistake:
    share = np.array([1.0, 1.0, _without(percent)])
    return Mistake(lambda mount: Pose(mount.t * share, mount.R))


def _zoomed(percent: float) -> Mistake:
    share = np.array([[_without(percent), 1, 1], [1, _without(percent), 1], [1, 1, 1]])
    return Mistake(camera=lambda camera: replace(camera, K=camera.K * share))


def _stretched(percent: float) -> Mistake:
    share = np.array([[_without(percent), 1, 1], [1, 1, 1], [1, 1, 1]])
    return Mistake(camera=lambda camera: replace(camera, K=camera.K * share))


def _bent(by: float) -> Mistake:
    return Mistake(camera=lambda camera: replace(camera, lens=camera.lens.bent(by)))


def _farther(percent: float) -> Mistake:
    return Mistake(base=lambda base: Pose(base.t * _without(percent), base.R))


WRONG_AMOUNTS = (
    WrongAmount(
        'the yaw of camera_pose', 'degrees', _yawed,
        _both_ways(10, 20, 30, 45, 60, 75, 105, 120, 135, 150, 165),
    ),
    WrongAmount(
        'the roll of camera_pose', 'degrees', _rolled, _both_ways(10, 20, 30, 45, 60, 75)
    ),
    WrongAmount('the pitch of camera_pose', 'degrees', pitched, _both_ways(6, 12, 20, 30, 45)),
    WrongAmount('the x of camera_pose', 'm', _moved(0), _both_ways(0.1, 0.2, 0.3, 0.5)),
    WrongAmount('the y of camera_pose', 'm', _moved(1), _both_ways(0.1, 0.2, 0.3, 0.5)),
    WrongAmount('the height of the camera', '%', _raised, (-60, -45, -30, 30, 60, 100)),
    WrongAmount(
        'the focal length of the calibration', '%', _zoomed,
        (-40, -30, -20, -10, 10, 20, 35, 60),
    ),
    WrongAmount(
        'the fx of the calibration, and not its fy,', '%', _stretched,
        (-30, -20, -10, 10, 20, 35),
    ),
    WrongAmount(
        'the first radial coefficient of the distortion', '', _bent, _both_ways(0.1, 0.2, 0.3)
    ),
    WrongAmount(
        'the time of odometry (positive: it is old)', 's', lambda s: Mistake(later=-s),
        _both_ways(0.05, 0.1, 0.15, 0.2, 0.3, LATEST),
    ),
    WrongAmount('the way that odometry tells', '%', _farther, (-90, -75, -50, -30, 50, 100)),
)  # fmt: skip
"""Smaller ones are hardly told from errors that are expected. Chosen."""
