"""The camera's own motion: it goes on as it was, and takes all tracks along.

The filters then hold what objects do beside it. Published are velocities in the picture, so that
nothing depends on whose motion it is that all share.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Viewpoint
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.ego_motion import EgoMotion
from colortrack_ros.tracking.ego_motion import find_ego_motion
from colortrack_ros.tracking.ego_motion import STANDING
from colortrack_ros.tracking.recent import Recent
from colortrack_ros.tracking.recent import Z

Floats = NDArray[np.float64]

UNSTEADINESS_MEMORY = 5
"""Frames over which the changes of its motion are averaged. Assumed: a pan starts and ends."""

STEADY_FRAMES = 3
"""Frames after which a motion that has not changed is given to the objects as their own, since the
filters of all know it better than what two frames say. Assumed."""


class Turn(NamedTuple):
    """What two known viewpoints make of a position.

    :param last: of the last frame.
    :param now: of this one.
    """

    last: Viewpoint
    now: Viewpoint

    def at(self, x: Floats) -> EgoMotion:
        """What it does to tracks at x, (N, 2) [px], each with an A and a shift of its own."""
        moved, A = self.now.moved(x, self.last)
        return EgoMotion(A, moved - _turned(A, x))

    def way(self, x: Floats) -> Floats:
        """How far positions, (..., 2) [px], have come, of where they are now."""
        return x - self.last.moved(x, self.now)[0]


class Camera:
    """How the camera moved in the last frame.

    :ivar is_known: whether somebody tells where it is.
    """

    def __init__(self) -> None:
        self._motion: EgoMotion | Turn = STANDING
        self._dt = 1.0
        self._viewpoint: Viewpoint | None = None
        self._change2, self._steady = np.zeros(2), 0

    @property
    def is_known(self) -> bool:
        """Whether somebody tells where it is."""
        return self._viewpoint is not None

    def turn(self, viewpoint: Viewpoint | None, dt: float) -> None:
        """Go to the next frame, of which it is known where it is taken; None: not known.

        :param dt: since the last frame [s].
        """
        last, self._viewpoint, self._dt = self._viewpoint, viewpoint, dt
        self._motion = Turn(last, viewpoint) if last and viewpoint else STANDING

    @property
    def stands(self) -> bool:
        """Whether it did not."""
        return self._motion is STANDING

    def follow(self, expected: Floats, variance: Floats, z: Floats, dt: float) -> None:
        """Go to the next frame; what is seen there corrects the motion.

        :param expected: (N, 2) predictions, without it, of objects measured in the last frame [px].
        :param variance: (N, 2) of these and of measurements [px^2].
        :param z: (M, 2) detections [px].
        :param dt: since the last frame [s].
        """
        assert isinstance(self._motion, EgoMotion)
        last = self._motion.during(dt / self._dt)
        self._motion, self._dt = last, dt
        if not len(z):
            return
        change = find_ego_motion(last.of(expected), variance, z)
        self._steady += 1
        if change is not None:
            self._motion, self._steady = change.after(last), 0
        if len(expected) and not (self.stands and last is STANDING):
            moved = (self._motion.of(expected) - last.of(expected)).mean(axis=0) / dt
            self._change2 += (moved**2 - self._change2) / UNSTEADINESS_MEMORY

    @property
    def is_steady(self) -> bool:
        """Whether it moves, but in the last frames alike."""
        known = isinstance(self._motion, Turn)
        return not known and not self.stands and self._steady >= STEADY_FRAMES

    def stop(self) -> None:
        """Stand from now on."""
        self._motion, self._viewpoint = STANDING, None

    def give(self, tracks: TrackTable[Bank], recent: Recent, now: int) -> None:
        """Let tracks have its motion as their own: what is recorded of their past moves back by it.

        :param recent: where the frames are in the records.
        :param now: stamp of the frame [ns].
        """
        if self.stands or not len(tracks):
            return
        records, way = tracks.records, self._motion.way(tracks.filters.estimate()[0][:, :2])
        way /= self._dt
        tracks.filters.accelerate(way)
        for name, since in (('before', 'met'), ('anchor', 'anchored')):
            T = (now - records[since]) / NANOSECONDS
            records[name][:, :2] -= T[:, None] * way
            records[name][:, 2:] += way
        T, sums = (now - records['apart']) / NANOSECONDS, records['sums']
        sums[:, 3:5] -= (T * sums[:, 0] - sums[:, 1])[:, None] * way
        sums[:, 5:7] -= (T * sums[:, 1] - sums[:, 2])[:, None] * way
        ages = recent.ages(self._dt)
        records['measured'][..., Z] -= ages[:, None] * way[:, None]
        records['probe'][:, 0] -= (recent.since_look(self._dt) * way)[..., None]
        records['probe'][:, 1] += way[..., None]

    def carry(self, tracks: TrackTable[Bank]) -> None:
        """Take tracks, and all that is recorded of their past, to where the camera has them now."""
        if self.stands or not len(tracks):
            return
        records = tracks.records
        A, shift, variance = self._motion.at(tracks.filters.estimate()[0][:, :2])
        tracks.filters.move(A, shift, variance)
        for name in ('before', 'anchor'):
            state = records[name]
            state[:, :2] = _turned(A, state[:, :2]) + shift
            state[:, 2:] = _turned(A, state[:, 2:])
        G = np.zeros((len(A), 4, 4))
        G[:, :2, :2] = G[:, 2:, 2:] = A
        records['before_cov'] = G @ records['before_cov'] @ G.swapaxes(1, 2)
        sums = records['sums']
        sums[:, 3:5] = _turned(A, sums[:, 3:5]) + sums[:, :1] * shift
        sums[:, 5:7] = _turned(A, sums[:, 5:7]) + sums[:, 1:2] * shift
        measured = _turned(A[:, None], records['measured'][..., Z]) + shift[:, None]
        records['measured'][..., Z] = measured
        probe = A[:, None] @ records['probe']
        probe[:, 0] += shift[:, :, None]
        records['probe'] = probe

    def publish(self, rows: NDArray[np.void]) -> None:
        """Add the motion to the velocities of published tracks, of dtype TRACK."""
        if self.stands or not len(rows):
            return
        way = self._motion.way(np.stack([rows['u'], rows['v']], axis=1)) / self._dt
        rows['du'] += way[:, 0]
        rows['dv'] += way[:, 1]
        rows['covariance'][:, (2, 3), (2, 3)] += self._change2


def _turned(A: Floats, x: Floats) -> Floats:
    """A x of vectors, (..., 2)."""
    return np.asarray((A @ x[..., None])[..., 0])
