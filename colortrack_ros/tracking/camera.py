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
from colortrack_ros.estimation.records import Records
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


CAMERA_FIELDS = [('nearness', 'f8'), ('left', 'i8')]
"""What is recorded of a track: one over the distance of its object from a camera of which it is
known where it is [1/m]; stamp of the last frame that it was outside of by that camera's motion
[ns]."""

SEEN_OUTSIDE = 0.02
"""Probability that an object can be seen though it is predicted outside the picture: what is
predicted from odometry is off by a few pixels at the border. Assumed."""


class Turn(NamedTuple):
    """What two known viewpoints make of positions.

    Objects that the picture shows are taken to stand on the ground, with their lower edges; others
    to be where they were seen last.

    :param last: of the last frame.
    :param now: of this one.
    :param stamp: of this one [ns].
    """

    last: Viewpoint
    now: Viewpoint
    stamp: int

    def take(self, x: Floats, records: Records) -> EgoMotion:
        """What it does to tracks, each with an A and a shift of its own.

        It is noted how near they have come, how large they look by that, and which are outside.

        :param x: (N, 2) where they were in the last frame [px].
        :param records: (N,) theirs.
        """
        near = _nearness(self.last, x, records)
        moved, A, now = self.now.moved(x, self.last, near)
        records['nearness'] = now
        records['extent'] *= np.divide(now, near, out=np.ones(len(x)), where=near > 0)[
            :, None, None
        ]
        outside = ~self.now.shows(moved, records['extent'])
        records['left'][outside] = self.stamp
        seen = records['visible'][outside] * SEEN_OUTSIDE
        records['hidden'][outside] += records['visible'][outside] - seen
        records['visible'][outside] = seen
        return EgoMotion(A, moved - _turned(A, x))

    def way(self, x: Floats, records: Records) -> Floats:
        """How far tracks have come, (N, 2) [px], of where they are now."""
        return x - self.last.moved(x, self.now, _nearness(self.now, x, records))[0]


def _nearness(view: Viewpoint, x: Floats, records: Records) -> Floats:
    """Of tracks at x, (N, 2), by their lower edges; unseen ones as it was: (N,) [1/m]."""
    reach = records['extent']
    feet = x + reach[:, 1] * [0.0, 1.0]
    return np.where(view.shows(x, reach), view.nearness(x, feet), records['nearness'])


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

    def turn(self, viewpoint: Viewpoint | None, stamp: int, dt: float) -> None:
        """Go to the next frame, of which it is known where it is taken; None: not known.

        :param stamp: of the frame [ns].
        :param dt: since the last frame [s].
        """
        last, self._viewpoint, self._dt = self._viewpoint, viewpoint, dt
        self._motion = Turn(last, viewpoint, stamp) if last and viewpoint else STANDING

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
        records, way = tracks.records, self._way(tracks)
        tracks.filters.accelerate(way)
        for name, since in (('before', 'met'), ('anchor', 'anchored')):
            T = (now - records[since]) / NANOSECONDS
            records[name][:, :2] -= T[:, None] * way
            records[name][:, 2:] += way
        for name, since in (('past', 'past_at'), ('seen', 'updated')):
            T = (now - records[since]) / NANOSECONDS
            records[name] -= T[..., None] * (way[:, None] if T.ndim > 1 else way)
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
        A, shift, variance = self._motion.take(tracks.filters.estimate()[0][:, :2], records)
        tracks.filters.move(A, shift, variance)
        records['seen'] = _turned(A, records['seen']) + shift
        records['past'] = _turned(A[:, None], records['past']) + shift[:, None]
        records['acceleration'] = _turned(A, records['acceleration'])
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

    def publish(self, rows: NDArray[np.void], tracks: TrackTable[Bank]) -> None:
        """Add the motion to the velocities of published tracks, of dtype TRACK.

        :param tracks: all of them.
        """
        if self.stands or not len(rows):
            return
        names = tracks.records['track_id']
        order = np.argsort(names)
        at = order[np.searchsorted(names, rows['track_id'], sorter=order)]
        way = self._way(tracks)[at]
        rows['du'] += way[:, 0]
        rows['dv'] += way[:, 1]
        rows['covariance'][:, (2, 3), (2, 3)] += self._change2

    def _way(self, tracks: TrackTable[Bank]) -> Floats:
        """What it adds to the velocities of tracks, (N, 2) [px/s]."""
        x = tracks.filters.estimate()[0][:, :2]
        return self._motion.way(x, tracks.records) / self._dt


def _turned(A: Floats, x: Floats) -> Floats:
    """A x of vectors, (..., 2)."""
    return np.asarray((A @ x[..., None])[..., 0])
