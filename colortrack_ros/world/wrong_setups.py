"""Common mistakes in mounting a camera on a robot, each with its message."""

from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import replace
from typing import TypeVar

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose

SIDEWAYS, UPSIDE = np.diag([1.0, -1.0, 1.0]), np.diag([1.0, 1.0, -1.0])
"""Mirrors of left and right, and of up and down, which change the signs of yaw and pitch."""

T = TypeVar('T')


def as_given(what: T) -> T:
    """Return the argument."""
    return what


@dataclass(frozen=True)
class Mistake:
    """How the setup would be if a mistake had been made; fields that are not given keep the setup.

    :ivar mount, base: corrections of the camera pose on the robot and of the robot pose, of V
        pictures at once: t (V, 3), R (V, 3, 3).
    :ivar camera: correction of the lens model.
    :ivar later: the right robot pose is the one given this much later [s].
    """

    mount: Callable[[Pose], Pose] = as_given
    base: Callable[[Pose], Pose] = as_given
    camera: Callable[[CameraModel], CameraModel] = as_given
    later: float = 0.0


def _scaled(share: float) -> Mistake:
    """Return a camera matrix scaled to another picture size."""
    return Mistake(camera=lambda camera: replace(camera, K=np.diag([share, share, 1.0]) @ camera.K))


def _rolled(degrees: float) -> Mistake:
    own = Pose.of_rpy(np.zeros(3), (np.radians(degrees), 0, 0))
    return Mistake(lambda mount: mount @ own)


def _yawed(degrees: float) -> Mistake:
    turn = Pose.of_rpy(np.zeros(3), (0, 0, np.radians(degrees))).R
    return Mistake(lambda mount: Pose(mount.t, turn @ mount.R))


def pitched(degrees: float) -> Mistake:
    """Return a camera that looks down further."""
    own = Pose.of_rpy(np.zeros(3), (0, np.radians(degrees), 0))
    return Mistake(lambda mount: mount @ own)


def _turned_frame(degrees: float) -> Mistake:
    turn = Pose.of_rpy(np.zeros(3), (0, 0, np.radians(degrees)))
    return Mistake(base=lambda base: base @ turn)


def _mirrored(pose: Pose, mirror: Floats) -> Pose:
    """Return a pose with its rotation mirrored, (3, 3) diagonal."""
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
    'the yaw of odometry has the wrong sign, and not its y: positive turns left': Mistake(
        base=lambda base: _mirrored(base, SIDEWAYS)
    ),
    'the y of odometry has the wrong sign, and not its yaw: positive is left': Mistake(
        base=lambda base: Pose(base.t * [1, -1, 1], base.R)
    ),
    'x and y of odometry are exchanged, and its yaw is not': Mistake(
        base=lambda base: Pose(base.t[..., [1, 0, 2]], base.R)
    ),
    'the yaw of odometry is off by pi/2: x of base_frame is forward': _turned_frame(-90),
    'the yaw of odometry is off by -pi/2: x of base_frame is forward': _turned_frame(90),
    'the yaw of odometry is off by pi: x of base_frame is forward': _turned_frame(180),
}
"""Messages, each with the correction."""

AS_GIVEN = Mistake()

OF_ABOUT = ' is off by about '
"""Text between a quantity and its error."""

FINE = 16
"""Number of finer amounts tried around the best coarse one: 1 to 4 degrees, 2 % of a focal length,
or 13 to 20 ms apart. Chosen."""


LATEST = 0.4
"""Largest delay of odometry that is tried [s]; poses are kept this much longer than pictures.
Chosen."""


@dataclass(frozen=True)
class WrongAmount:
    """A number of the setup that is wrong.

    :ivar about: its name; unit: of the amounts.
    :ivar of: the correction, by the amount to add.
    :ivar amounts: (V,) ascending errors that are tried first.
    :ivar amount: the error of this one.
    """

    about: str
    unit: str
    of: Callable[[float], Mistake]
    amounts: tuple[float, ...]
    amount: float = 0.0

    @property
    def line(self) -> str:
        """Message."""
        return f'{self.about}{OF_ABOUT}{self.amount:+.3g} {self.unit}'.rstrip()

    @property
    def mistake(self) -> Mistake:
        """Correction."""
        return self.of(-self.amount)

    def coarse(self) -> list['WrongAmount']:
        """Return this with each of the coarse amounts."""
        return [replace(self, amount=amount) for amount in self.amounts]

    def around(self) -> list['WrongAmount']:
        """Return this with amounts near its own that are large enough to be a mistake."""
        at, least = self.amounts.index(self.amount), min(map(abs, self.amounts))
        low, high = self.amounts[max(at - 1, 0)], self.amounts[min(at + 1, len(self.amounts) - 1)]
        fine = np.append(np.linspace(low, high, FINE), self.amount)
        return [replace(self, amount=float(amount)) for amount in fine[np.abs(fine) >= least]]


def _both_ways(*amounts: float) -> tuple[float, ...]:
    return *(-amount for amount in amounts[::-1]), *amounts


def _without(percent: float) -> float:
    """Return the factor that corrects a number too small by percent of the true one."""
    return 1 / (1 - percent / 100)


def _moved(axis: int) -> Callable[[float], Mistake]:
    """Return a correction that moves the camera along an axis of the robot by meters."""
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


def _turned(percent: float) -> Mistake:
    return Mistake(base=lambda base: _turning(base, _without(percent)))


def _turning(base: Pose, share: float) -> Pose:
    """Return the way of V poses if the robot turned by another share, and drove as far.

    On the ground: steps point along the heading in the middle of each.
    """
    yaw = np.unwrap(np.arctan2(base.R[:, 1, 0], base.R[:, 0, 0]))
    more = (share - 1) * (yaw - yaw[0])
    middle = (more[1:] + more[:-1]) / 2
    steps = np.einsum('vij,vj->vi', _yaws(middle), np.diff(base.t, axis=0))
    t = base.t[0] + np.append(np.zeros((1, 3)), np.cumsum(steps, axis=0), axis=0)
    return Pose(t, _yaws(more) @ base.R)


def _yaws(angles: Floats) -> Floats:
    """Return rotations about z, (V, 3, 3)."""
    R = np.zeros((len(angles), 3, 3))
    R[:, 0, 0] = R[:, 1, 1] = np.cos(angles)
    R[:, 1, 0] = np.sin(angles)
    R[:, 0, 1], R[:, 2, 2] = -R[:, 1, 0], 1.0
    return R


TIME_OF_ODOMETRY = WrongAmount(
    'the time of odometry (positive: it is old)', 's', lambda s: Mistake(later=-s),
    _both_ways(0.05, 0.1, 0.15, 0.2, 0.3, LATEST),
)  # fmt: skip

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
    TIME_OF_ODOMETRY,
    WrongAmount(
        'the way that odometry tells', '%', _farther,
        (-90, -75, -50, -30, -20, -12, 15, 25, 50, 100),
    ),
    WrongAmount(
        'the turns that odometry tells', '%', _turned, (-50, -30, -20, -12, 15, 25, 50, 100)
    ),
)  # fmt: skip
"""Smaller errors are hard to tell from expected ones. Chosen."""
