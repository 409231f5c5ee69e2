"""State vectors: pose and velocity of each object, and the errors of the cameras.

An object has 8 numbers: position and velocity in the fixed frame, and the errors of its center's
height above the ground [m] and of its diameter [m]. Of what falls, no height is known; instead, the
first is the error of its drag [1/m]. Each camera adds 8 more, which all objects
share: the errors of its pose on the robot (x, y, z [m], roll, pitch, yaw [rad]), of the edge of its
blobs [px], and of the scale of its depth [1]. Then follows, for each camera, the time by which the
stamps of its pictures are early [s]. The last is the error of the scale of ways by odometry, unless
that is taken to be exact. These errors are constant, so averaging does not remove
them; seeing a standing object from several places makes them observable.

Given the camera errors, objects are independent of each other. Each object is therefore stored as
its state at the estimated errors, the slope of that state with respect to the errors, and the
covariance conditional on them (the separate-bias form of the Kalman filter, Friedland 1969): N
small matrices instead of one of size 8 N + 9.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from colortrack_ros.columns import Columns
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.world.config import ALOFT
from colortrack_ros.world.config import LocatorConfig

POSITION, VELOCITY, ALONG_GROUND = slice(0, 3), slice(3, 6), slice(3, 5)
BIASES, HEIGHT, DRAG, DIAMETER = slice(6, 8), 6, 6, 7
SHIFT, TILT, OF_MOUNT = slice(8, 11), slice(11, 14), slice(8, 14)
EDGE, SCALE = 14, 15
SIZE, OF_OBJECT, OF_CAMERA = 16, 8, 8
"""Size of the joint state of an object and one camera, and the share of each in it."""

CREEP = 0.05
"""Speed below which an object is said to stand [m/s], as `slow` of `benchmark/world.py` counts it;
it is also the published uncertainty of the velocity of a standing object."""

SLOWLY = 0.1
"""Standard deviation of the velocity of what does not move as its kind is said to, as a share of
`speed`. By `speed` alone, one in 200 of what may move at 1 m/s on each axis would roll at less than
0.1 m/s. With 0.055, balls with speeds of 0.3 m/s on each axis, before a robot that drives, are in
their 95 % ellipsoid in 86 instead of 90 % of the rows (60 runs, seed 3)."""

STANDS, MOVES = 0, 1
"""Indices of the motion hypotheses."""

GRAVITY = 9.80665
"""Standard gravity [m/s^2]."""


@dataclass
class Kinds(Columns):
    """Known properties of N objects, one row each.

    :ivar diameter: (N,) [m], 0 if unknown.
    :ivar height: (N,) height of the center above the ground [m].
    :ivar bound: (N,) whether the object stays at that height.
    :ivar falls: (N,) whether the object falls freely.
    :ivar bounce: (N,) restitution.
    :ivar speed: (N, 3) standard deviation of the initial velocity [m/s].
    :ivar slow: (N,) standard deviation of the velocities along the ground of what seems to stand
        [m/s]; 0 if it is below CREEP, and once an object surely stands.
    :ivar wander: (N, 3) standard deviation of the velocity change within 1 s [m/s].
    :ivar drag: (N,) deceleration by the air over squared speed [1/m].
    :ivar sigma: (N, 2) standard deviations of HEIGHT [m], of what falls DRAG [1/m], and of DIAMETER
        [m].
    """

    diameter: Floats
    height: Floats
    bound: Bools
    falls: Bools
    bounce: Floats
    speed: Floats
    slow: Floats
    wander: Floats
    drag: Floats
    sigma: Floats

    @classmethod
    def of(cls, config: LocatorConfig) -> 'Kinds':
        """Return the kinds of the configured colors, in their order."""
        each = [kind.config for kind in config.colors]
        free = np.array(
            [[c.motion != 'still'] * 2 + [c.motion in ALOFT] for c in each], float
        ).reshape(-1, 3)
        falls = np.array([c.motion == 'free_fall' for c in each], bool)
        own = [
            [c.drag_sigma if c.motion == 'free_fall' else c.height_sigma, c.diameter_sigma]
            for c in each
        ]
        bound = np.array([c.motion not in ALOFT for c in each], bool)
        speed = free * np.array([kind.first_speed for kind in config.colors])[:, None]
        slow = SLOWLY * speed[:, 0] * bound
        return cls(
            diameter=np.array([c.diameter for c in each], float),
            height=np.array([kind.center_height for kind in config.colors], float),
            bound=bound,
            falls=falls,
            bounce=np.array([c.bounce for c in each], float),
            speed=speed,
            slow=np.where(slow > CREEP, slow, 0.0),
            wander=free * np.array([c.wander for c in each])[:, None],
            drag=np.array([c.drag for c in each], float),
            sigma=np.array(own, float).reshape(-1, 2),
        )


@dataclass
class CameraErrors:
    """Estimated errors of the C cameras of each of G robots, and of the scale of its ways.

    Where shapes say 9 C, it is 9 C + 1 if the scale is among them.

    :ivar mean: (G, 9 C); cov: (G, 9 C, 9 C).
    :ivar first: (9 C, 9 C) covariance before any measurement.
    """

    mean: Floats
    cov: Floats
    first: Floats

    @classmethod
    def of(cls, config: LocatorConfig, cameras: int = 1, robots: int = 1) -> 'CameraErrors':
        """Return the configured prior, the same for all cameras."""
        sigma = [*config.camera_pose_sigma, config.size_sigma, config.depth_sigma] * cameras
        sigma += [config.stamp_sigma] * cameras
        if config.way_sigma > 0:
            sigma.append(config.way_sigma)
        first = np.diag(np.square(sigma))
        return cls(np.zeros((robots, len(sigma))), np.tile(first, (robots, 1, 1)), first)

    def robots(self, rows: Indices, count: int) -> Indices:
        """Return whose objects these rows of count are, (K,), grouped by robot."""
        return rows // max(count // len(self.mean), 1)

    @property
    def scaled(self) -> bool:
        """Whether the last error is that of the scale of ways."""
        return len(self.first) % (OF_CAMERA + 1) == 1

    @cached_property
    def unit(self) -> Floats:
        """Standard deviations before any measurement, (9 C,), 1 for those of 0."""
        sigma = np.sqrt(np.diag(self.first))
        return np.where(sigma > 0, sigma, 1.0)

    def spread(self, slope: Floats, apart: Floats) -> Floats:
        """Return slope cov slope^T + apart apart^T of objects, (N, 8, 8), grouped by robot.

        :param slope: (N, 8, 9 C) derivative of states by the errors; apart: (N, 8).
        """
        robots, size = self.mean.shape
        wide = np.empty((len(slope), OF_OBJECT, size + 1))
        wide[..., :-1], wide[..., -1] = slope, apart
        by = wide.copy()
        by[..., :-1] = (slope.reshape(robots, -1, size) @ self.cov).reshape(slope.shape)
        return by @ wide.swapaxes(1, 2)


@dataclass
class Motions(Columns):
    """States of N objects under two hypotheses each: standing and moving.

    Covariance, slope, and mean are columns of one matrix, so linear operations apply to all at
    once.

    :ivar whole: (N, 2, 8, 8 + 9 C + 1) cov, slope, and mean, side by side.
    :ivar probability: (N, 2) of each hypothesis.
    """

    whole: Floats
    probability: Floats

    @classmethod
    def of(cls, mean: Floats, slope: Floats, cov: Floats, probability: Floats) -> 'Motions':
        """Assemble the states from their parts."""
        return cls(np.concatenate([cov, slope, mean[..., None]], axis=-1), probability)

    def __len__(self) -> int:
        return len(self.probability)

    @classmethod
    def none(cls, errors: int) -> 'Motions':
        """Return a table without objects, given the number of camera errors."""
        width = OF_OBJECT + errors + 1
        return cls(np.zeros((0, 2, OF_OBJECT, width)), np.zeros((0, 2)))

    @property
    def mean(self) -> Floats:
        """The state at the estimated camera errors, (N, 2, 8), a view."""
        return self.whole[..., -1]

    @property
    def slope(self) -> Floats:
        """The derivative of the mean by the camera errors, (N, 2, 8, 9 C), a view."""
        return self.whole[..., OF_OBJECT:-1]

    @property
    def cov(self) -> Floats:
        """The covariance conditional on the camera errors, (N, 2, 8, 8), a view."""
        return self.whole[..., :OF_OBJECT]

    def shifted(self, change: Floats) -> 'Motions':
        """Return the states after a change of the camera errors, (N, 9 C)."""
        there = Motions(self.whole.copy(), self.probability)
        there.mean[...] += (self.slope @ change[:, None, :, None])[..., 0]
        return there

    def combined(self, errors: CameraErrors) -> tuple[Floats, Floats]:
        """Return mean, (N, 8), and covariance, (N, 8, 8), including all sources of uncertainty."""
        p = self.probability
        count, _, size, width = self.whole.shape
        whole = p[:, None] @ self.whole.reshape(count, 2, size * width)
        whole = whole.reshape(count, size, width)
        cov, mean = whole[..., :OF_OBJECT], whole[..., -1]
        d = self.mean[:, MOVES] - self.mean[:, STANDS]
        d *= np.sqrt(p[:, STANDS] * p[:, MOVES])[:, None]
        cov = cov + errors.spread(whole[..., OF_OBJECT:-1], d)
        creeps = np.einsum('nii->ni', cov[:, VELOCITY, VELOCITY])  # a view
        creeps += CREEP**2 * p[:, STANDS, None]
        return mean, cov


def time_of(camera: int, errors: int) -> int:
    """Return which of so many errors is that of the time of a camera."""
    return OF_CAMERA * (errors // (OF_CAMERA + 1)) + camera


def columns_of(camera: int) -> Indices:
    """Return which columns of a state one camera measures, (16,)."""
    own = np.arange(SIZE)
    own[SIZE - OF_CAMERA :] += OF_CAMERA * camera
    return own


def add_white(cov: Floats, change: Floats, dt: float) -> None:
    """Add the noise of a white acceleration to covariances, (N, 8, 8), in place.

    Q = c [dt^2/3, dt/2; dt/2, 1] on each axis (Bar-Shalom 2001, 6.2.2).

    :param change: (N, 3) c, the variance of the change of velocity [m^2/s^2].
    """
    Q = np.array([[dt * dt / 3, dt / 2], [dt / 2, 1.0]])
    blocks = cov[:, :6, :6].reshape(-1, 2, 3, 2, 3)
    each_axis = np.einsum('npaqa->npqa', blocks)  # a view
    each_axis += Q[:, :, None] * change[:, None, None, :]
