"""The states: of each object where it is and goes, and of the cameras how they are off.

An object has 8 numbers: position and velocity in the fixed frame, and the errors of the height of
its center above the ground [m] and of its diameter [m]. A camera has 8 more, which all objects
share: the errors of its place on the robot (x, y, z [m], roll, pitch, yaw [rad]), of the edge of
its blobs [px] and of the scale of its depth [1]. These last, so no averaging removes them; what
tells of them is that what stands is seen from several places.

Given the errors of the cameras, objects are independent of each other. So each is kept as its state
if the errors were as estimated, how that changes with them, and the covariance that would be left
if they were known (the separate-bias form of the Kalman filter, Friedland 1969): N small matrices
instead of one of 8 N + 8.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Columns
from colortrack_ros.world.config import ALOFT
from colortrack_ros.world.config import LocatorConfig

Floats = NDArray[np.float64]

POSITION, VELOCITY = slice(0, 3), slice(3, 6)
BIASES, HEIGHT, DIAMETER = slice(6, 8), 6, 7
SHIFT, TILT = slice(8, 11), slice(11, 14)
EDGE, SCALE = 14, 15
SIZE, OF_OBJECT, OF_CAMERA = 16, 8, 8
"""Numbers of an object and one camera, and of them those of each."""

CREEP = 0.05
"""What is slower [m/s] is said to stand; so its velocity is published as uncertain by as much."""

STANDS, MOVES = 0, 1
"""The hypotheses of how an object moves."""

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
    :ivar sigma: (N, 2) standard deviations of HEIGHT and DIAMETER [m].
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
            [[c.motion != 'still'] * 2 + [c.motion in ALOFT] for c in each], float
        ).reshape(-1, 3)
        own = [[c.height_sigma, c.diameter_sigma] for c in each]
        falls = np.array([c.motion == 'free_fall' for c in each], bool)
        return cls(
            diameter=np.array([c.diameter for c in each], float),
            height=np.array([kind.center_height for kind in config.colors], float),
            bound=np.array([c.motion not in ALOFT for c in each], bool),
            falls=falls,
            bounce=np.array([c.bounce for c in each], float),
            speed=free * np.array([c.speed for c in each])[:, None],
            wander=free * np.array([c.wander for c in each])[:, None],
            sigma=np.array(own, float).reshape(-1, 2),
        )


@dataclass
class CameraErrors:
    """How the C cameras of each of G robots are off, as far as is known.

    :ivar mean: (G, 8 C); cov: (G, 8 C, 8 C).
    :ivar first: (8 C, 8 C) covariance of which nothing has been seen yet.
    """

    mean: Floats
    cov: Floats
    first: Floats

    @classmethod
    def of(cls, config: LocatorConfig, cameras: int = 1, robots: int = 1) -> 'CameraErrors':
        """As configured, the same of all cameras."""
        sigma = [*config.camera_pose_sigma, config.size_sigma, config.depth_sigma] * cameras
        first = np.diag(np.square(sigma))
        return cls(np.zeros((robots, len(sigma))), np.tile(first, (robots, 1, 1)), first)


@dataclass
class Motions(Columns):
    """The states of N objects by each of two hypotheses: that they stand, that they move.

    Covariance, slope and mean are the columns of one matrix: what is linear is done to all at once.

    :ivar whole: (N, 2, 8, 8 + 8 C + 1) of cov, slope and mean, side by side.
    :ivar probability: (N, 2) of each hypothesis.
    """

    whole: Floats
    probability: Floats

    @classmethod
    def of(cls, mean: Floats, slope: Floats, cov: Floats, probability: Floats) -> 'Motions':
        """Of the parts."""
        return cls(np.concatenate([cov, slope, mean[..., None]], axis=-1), probability)

    @classmethod
    def none(cls, cameras: int) -> 'Motions':
        """Of no object."""
        width = OF_OBJECT + OF_CAMERA * cameras + 1
        return cls(np.zeros((0, 2, OF_OBJECT, width)), np.zeros((0, 2)))

    @property
    def mean(self) -> Floats:
        """A view, (N, 2, 8): the state if the errors of the cameras are as estimated."""
        return self.whole[..., -1]

    @property
    def slope(self) -> Floats:
        """A view, (N, 2, 8, 8 C): how the mean changes with these errors."""
        return self.whole[..., OF_OBJECT:-1]

    @property
    def cov(self) -> Floats:
        """A view, (N, 2, 8, 8): the covariance that is left if they are known."""
        return self.whole[..., :OF_OBJECT]

    def shifted(self, change: Floats) -> 'Motions':
        """These, as they follow a change of the errors of the cameras, (N, 8 C)."""
        there = Motions(self.whole.copy(), self.probability)
        there.mean[...] += (self.slope @ change[:, None, :, None])[..., 0]
        return there

    def combined(self, errors: CameraErrors) -> tuple[Floats, Floats]:
        """Mean, (N, 8), and covariance, (N, 8, 8), with all that is not known."""
        p, P = self.probability[..., None, None], errors.cov
        P = np.repeat(P, len(self) // len(P), axis=0)
        count, _, size, width = self.whole.shape
        whole = self.probability[:, None] @ self.whole.reshape(count, 2, size * width)
        whole = whole.reshape(count, size, width)
        cov, slope, mean = whole[..., :OF_OBJECT], whole[..., OF_OBJECT:-1], whole[..., -1]
        d = self.mean[:, MOVES] - self.mean[:, STANDS]
        cov = cov + slope @ P @ slope.swapaxes(1, 2)
        cov += p[:, STANDS] * p[:, MOVES] * d[:, :, None] * d[:, None, :]
        creeps = np.einsum('nii->ni', cov[:, VELOCITY, VELOCITY])  # a view
        creeps += CREEP**2 * p[:, STANDS, 0]
        return mean, cov


def columns_of(camera: int) -> NDArray[np.intp]:
    """Which numbers of a state are those that one camera measures, (16,)."""
    own = np.arange(SIZE)
    own[SIZE - OF_CAMERA :] += OF_CAMERA * camera
    return own
