"""The state of each object: where it is and goes, and what is off in how it is measured.

16 numbers with one camera: position and velocity in the fixed frame, and the errors that do not
average out: of the height of the center above the ground [m], of the diameter [m], and of the
camera, its place on the robot (x, y, z [m], roll, pitch, yaw [rad]), the edge of its blobs [px] and
the scale of its depth [1]. Each further camera has these eight once more.

They start with their known standard deviations, and correlate with the position that they are in;
so the covariance of the position never falls below what they leave open.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import COASTING
from colortrack_ros.data import Columns
from colortrack_ros.data import CONFIRMED
from colortrack_ros.world.config import LocatorConfig

Floats = NDArray[np.float64]

POSITION, VELOCITY = slice(0, 3), slice(3, 6)
BIASES = slice(6, None)
HEIGHT, DIAMETER = 6, 7
SHIFT, TILT = slice(8, 11), slice(11, 14)
EDGE, SCALE = 14, 15
SIZE, OF_CAMERA = 16, 8
"""Numbers with one camera, and of them those that are the camera's."""

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
    :ivar sigma: (N, 2 + 8 C) standard deviations of the BIASES, with C cameras.
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
    def of(cls, config: LocatorConfig, cameras: int = 1) -> 'Kinds':
        """The colors, in their order."""
        each = [kind.config for kind in config.colors]
        free = np.array(
            [[c.motion != 'still'] * 2 + [c.motion == 'free_fall'] for c in each], float
        ).reshape(-1, 3)
        own = [[c.height_sigma, c.diameter_sigma] for c in each]
        camera = [*config.camera_pose_sigma, config.size_sigma, config.depth_sigma]
        sigma = [[*one, *(camera * cameras)] for one in own]
        falls = np.array([c.motion == 'free_fall' for c in each], bool)
        return cls(
            diameter=np.array([c.diameter for c in each], float),
            height=np.array([kind.center_height for kind in config.colors], float),
            bound=~falls,
            falls=falls,
            bounce=np.array([c.bounce for c in each], float),
            speed=free * np.array([c.speed for c in each])[:, None],
            wander=free * np.array([c.wander for c in each])[:, None],
            sigma=np.array(sigma, float).reshape(-1, 2 + OF_CAMERA * cameras),
        )


@dataclass
class Objects(Columns):
    """The objects, one row each, seen by C cameras.

    :ivar object_id, color: (N,).
    :ivar track_id: (N, C) the track of each camera that is of it, 0 for none.
    :ivar states, scores: (N, C) of these tracks, 0 for none.
    :ivar updates: (N, C) when each camera has measured it last, and was not refused [ns].
    :ivar mean: (N, n), cov: (N, n, n), with n = 8 + 8 C.
    :ivar kinds: what is known of them.
    """

    object_id: NDArray[np.int64]
    color: NDArray[np.int64]
    track_id: NDArray[np.int64]
    states: NDArray[np.uint8]
    scores: Floats
    updates: NDArray[np.int64]
    mean: Floats
    cov: Floats
    kinds: Kinds

    @classmethod
    def none(cls, kinds: Kinds, cameras: int) -> 'Objects':
        """No object yet."""
        ids, each = np.zeros(0, np.int64), np.zeros((0, cameras), np.int64)
        size = SIZE + OF_CAMERA * (cameras - 1)
        return cls(
            ids, ids, each, each.astype(np.uint8), each.astype(float), each,
            np.zeros((0, size)), np.zeros((0, size, size)), kinds.take(ids),
        )  # fmt: skip

    @property
    def state(self) -> NDArray[np.uint8]:
        """The best that any camera says, (N,)."""
        coasting = (self.states == COASTING).any(axis=1) * COASTING
        return np.where((self.states == CONFIRMED).any(axis=1), CONFIRMED, coasting).astype(
            np.uint8
        )

    @property
    def score(self) -> Floats:
        """The highest, (N,)."""
        return np.asarray(self.scores.max(axis=1, initial=0.0))

    @property
    def updated(self) -> NDArray[np.int64]:
        """When last measured, (N,) [ns]."""
        return np.asarray(self.updates.max(axis=1, initial=0))

    def follow(self, tracks: NDArray[np.void], camera: int) -> None:
        """Note what the tracks of a camera tell, and drop what no camera has a track of any more.

        :param tracks: all of the camera, of dtype TRACK, ascending.
        """
        own = self.track_id[:, camera]
        self.unlink((~np.isin(own, tracks['track_id'])).nonzero()[0], camera)
        (rows,) = own.nonzero()
        at = np.searchsorted(tracks['track_id'], own[rows])
        self.states[rows, camera] = tracks['state'][at]
        self.scores[rows, camera] = tracks['score'][at]
        self.keep(np.flatnonzero(self.track_id.any(axis=1)))

    def link(
        self, rows: NDArray[np.intp], tracks: NDArray[np.void], camera: int, stamp: int
    ) -> None:
        """Note which tracks of a camera, (K,), are of objects that it has just measured, (K,)."""
        self.track_id[rows, camera] = tracks['track_id']
        self.states[rows, camera] = tracks['state']
        self.scores[rows, camera] = tracks['score']
        self.updates[rows, camera] = stamp

    def unlink(self, rows: NDArray[np.intp], camera: int) -> None:
        """Note that a camera has no track of objects, (K,), any more."""
        self.track_id[rows, camera], self.states[rows, camera] = 0, 0
        self.scores[rows, camera] = 0.0


def columns_of(camera: int) -> NDArray[np.intp]:
    """Which numbers of a state are those that one camera measures, (16,)."""
    own = np.arange(SIZE)
    own[SIZE - OF_CAMERA :] += OF_CAMERA * camera
    return own
