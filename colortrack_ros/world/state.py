"""The state of each object: where it is and goes, and what is off in how it is measured.

16 numbers: position and velocity in the fixed frame, and the errors that do not average out: of the
camera's place on the robot (x, y, z [m], roll, pitch, yaw [rad]), of the height of the center above
the ground [m], of the diameter [m], of the edge of its blobs [px], of the scale of the depth [1].
They start with their known standard deviations, and correlate with the position that they are in;
so the covariance of the position never falls below what they leave open.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Columns
from colortrack_ros.world.config import LocatorConfig

Floats = NDArray[np.float64]

POSITION, VELOCITY = slice(0, 3), slice(3, 6)
BIASES = slice(6, 16)
SHIFT, TILT = slice(6, 9), slice(9, 12)
HEIGHT, DIAMETER, EDGE, SCALE = 12, 13, 14, 15
SIZE = 16

GRAVITY = 9.80665
"""Standard gravity [m/s^2]."""


@dataclass
class Kinds(Columns):
    """What is known of objects, one row each.

    :ivar diameter: (N,) [m], 0 where not known.
    :ivar height: (N,) of the center above the ground [m].
    :ivar bound: (N,) whether it stays at that height.
    :ivar falls: (N,) whether it falls.
    :ivar bounce: (N,) restitution.
    :ivar speed: (N, 3) standard deviation of the first velocity [m/s].
    :ivar wander: (N, 3) standard deviation of the change of velocity within 1 s [m/s].
    :ivar sigma: (N, 10) standard deviations of the BIASES.
    """

    diameter: Floats
    height: Floats
    bound: NDArray[np.bool_]
    falls: NDArray[np.bool_]
    bounce: Floats
    speed: Floats
    wander: Floats
    sigma: Floats

    @classmethod
    def of(cls, config: LocatorConfig) -> 'Kinds':
        """The colors, in their order."""
        each = [kind.config for kind in config.colors]
        free = np.array(
            [[c.motion != 'still'] * 2 + [c.motion == 'free_fall'] for c in each], float
        ).reshape(-1, 3)
        own = [[c.height_sigma, c.diameter_sigma] for c in each]
        both = [config.size_sigma, config.depth_sigma]
        sigma = [[*config.camera_pose_sigma, *one, *both] for one in own]
        falls = np.array([c.motion == 'free_fall' for c in each], bool)
        return cls(
            diameter=np.array([c.diameter for c in each], float),
            height=np.array([kind.center_height for kind in config.colors], float),
            bound=~falls,
            falls=falls,
            bounce=np.array([c.bounce for c in each], float),
            speed=free * np.array([c.speed for c in each])[:, None],
            wander=free * np.array([c.wander for c in each])[:, None],
            sigma=np.array(sigma, float).reshape(-1, 10),
        )


@dataclass
class Objects(Columns):
    """The objects, one row each.

    :ivar track_id, color, state: (N,) of the track.
    :ivar score: (N,) of the track.
    :ivar updated: (N,) when last measured [ns].
    :ivar mean: (N, 16); cov: (N, 16, 16).
    :ivar kinds: what is known of them.
    """

    track_id: NDArray[np.int64]
    color: NDArray[np.int64]
    state: NDArray[np.uint8]
    score: Floats
    updated: NDArray[np.int64]
    mean: Floats
    cov: Floats
    kinds: Kinds
