"""The camera's own motion: it goes on as it was, and takes all tracks along.

The filters then hold what objects do beside it. Published are velocities in the picture, so that
nothing depends on whose motion it is that all share.
"""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.track_table import TrackTable
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


class Camera:
    """How the camera moved in the last frame."""

    def __init__(self) -> None:
        self._motion, self._dt = STANDING, 1.0
        self._change2, self._steady = np.zeros(2), 0

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
        return not self.stands and self._steady >= STEADY_FRAMES

    def stop(self) -> None:
        """Stand from now on."""
        self._motion = STANDING

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
        motion, A, records = self._motion, self._motion.A, tracks.records
        tracks.filters.move(A, motion.shift, motion.variance)
        for name in ('before', 'anchor'):
            state = records[name]
            state[:, :2] = motion.of(state[:, :2])
            state[:, 2:] = state[:, 2:] @ A.T
        G = np.kron(np.eye(2), A)
        records['before_cov'] = G @ records['before_cov'] @ G.T
        sums = records['sums']
        sums[:, 3:5] = sums[:, 3:5] @ A.T + sums[:, :1] * motion.shift
        sums[:, 5:7] = sums[:, 5:7] @ A.T + sums[:, 1:2] * motion.shift
        records['measured'][..., Z] = motion.of(records['measured'][..., Z])
        probe = A @ records['probe']
        probe[:, 0] += motion.shift[:, None]
        records['probe'] = probe

    def publish(self, rows: NDArray[np.void]) -> None:
        """Add the motion to the velocities of published tracks, of dtype TRACK."""
        if self.stands or not len(rows):
            return
        way = self._motion.way(np.stack([rows['u'], rows['v']], axis=1)) / self._dt
        rows['du'] += way[:, 0]
        rows['dv'] += way[:, 1]
        rows['covariance'][:, (2, 3), (2, 3)] += self._change2
