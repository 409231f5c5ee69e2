"""Calibrations that are wrong by what happens to people: what is told, by what is true."""

from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import replace

import numpy as np

from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose


def same(what):
    return what


@dataclass(frozen=True)
class Wrong:
    """What is told of the first camera, of odometry, and of the balls.

    :ivar mount, camera: what is told, by the true ones.
    :ivar way: what ways are told to be longer by; diameter: of balls.
    :ivar apart: by how much the pictures of each camera are stamped late [s].
    """

    mount: Callable[[Pose], Pose] = same
    camera: Callable[[CameraModel], CameraModel] = same
    way: float = 1.0
    diameter: float = 1.0
    apart: tuple = (0.0, 0.0)


def scaled(by, size=1.0):
    """A calibration with other focal lengths, or of pictures of another size."""
    K = np.array([[by, 1, size], [1, by, size], [1, 1, 1]])
    return lambda camera: replace(
        camera, K=camera.K * K, width=round(size * camera.width), height=round(size * camera.height)
    )


def raised(by):
    return lambda mount: Pose(mount.t * [1, 1, by], mount.R)


def turned(roll, pitch):
    return lambda mount: mount @ Pose.of_rpy((0, 0, 0), (roll, pitch, 0))


WRONG = {
    'right': Wrong(),
    'height 5 % too small': Wrong(raised(0.95)),
    'height 5 % too large': Wrong(raised(1.05)),
    'pitch 2 degrees too large': Wrong(turned(0, np.radians(2))),
    'pitch 2 degrees too small': Wrong(turned(0, -np.radians(2))),
    'focal length 3 % too large': Wrong(camera=scaled(1.03)),
    'focal length 3 % too small': Wrong(camera=scaled(0.97)),
    'diameter 5 % too large': Wrong(diameter=1.05),
    'diameter 5 % too small': Wrong(diameter=0.95),
    'optical frame': Wrong(lambda mount: mount @ OPTICAL),
    'frame of the body': Wrong(lambda mount: mount @ OPTICAL.inverse()),
    'calibration of 1280x960': Wrong(camera=scaled(2, 2)),
    'calibration of 800x600': Wrong(camera=scaled(1.25, 1.25)),
    'calibration of 320x240': Wrong(camera=scaled(0.5, 0.5)),
    'wheels 3 % too large': Wrong(way=1.03),
    'wheels 3 % too small': Wrong(way=0.97),
    'upside down': Wrong(turned(np.pi, 0)),
    'stamps 50 ms late': Wrong(apart=(0.05, 0.0)),
    'stamps 50 ms early': Wrong(apart=(-0.05, 0.0)),
    'stamps 50 ms late, 30 ms early': Wrong(apart=(0.05, -0.03)),
}  # fmt: skip
