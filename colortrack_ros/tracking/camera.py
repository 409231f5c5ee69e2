"""Camera: its motion from frame to frame, assumed to continue, carries all tracks along.

The filters hold the motion of objects relative to it. Published velocities are those in the
picture, so nothing depends on how common motion is split between camera and objects.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Viewpoint
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.ego_motion import count_found
from colortrack_ros.tracking.ego_motion import EgoMotion
from colortrack_ros.tracking.ego_motion import find_ego_motion
from colortrack_ros.tracking.ego_motion import STANDING
from colortrack_ros.tracking.parallax import off_nearness
from colortrack_ros.tracking.recent import Recent
from colortrack_ros.tracking.recent import Z

Find = Callable[[Floats, Floats, Floats], EgoMotion | None]

UNSTEADINESS_MEMORY = 5
"""Frames over which changes of the camera's motion are averaged. Assumed: a pan starts and ends."""

STEADY_FRAMES = 3
"""Frames without a change after which the camera's motion is added to that of the objects: the
filters of all of them estimate it better than two frames do. Assumed."""

ALERT = 1.0
"""Time after a change of the camera's motion in which every motion that most objects share is taken
for the camera's [s]: one that was moved goes on, or back. Assumed."""

CAMERA_FIELDS = [('nearness', 'f8'), ('aloft', '?'), ('left', 'i8')]
"""Camera fields of a track: inverse distance of its object from a camera of known pose [1/m];
whether its parallax has shown that it does not stand on the ground; stamp of the last frame in
which the motion of that camera left it outside the picture [ns]."""

SEEN_OUTSIDE = 0.02
"""Probability that an object predicted outside the picture is visible: predictions from odometry
are off by a few pixels at the border. Assumed."""

NEARER = 0.01
"""Step of inverse distances for a derivative [1/m]: of a motion that is almost linear in it."""


class Turn(NamedTuple):
    """Motion of positions between two known viewpoints.

    Objects in the picture are assumed to stand on the ground with their lower edges; those that
    leave it, where their parallax says; others, to be where they were last seen.

    :param last: viewpoint of the last frame.
    :param now: viewpoint of this frame.
    :param stamp: of this frame [ns]; dt: since the last [s].
    """

    last: Viewpoint
    now: Viewpoint
    stamp: int
    dt: float

    def take(self, tracks: TrackTable[Bank]) -> EgoMotion:
        """Return the motion of tracks, with an A and a shift for each.

        Updates the recorded inverse distance, the extent that follows from it, and which tracks are
        outside the picture; of those that leave it, the velocity.
        """
        x, records = tracks.filters.estimate()[0][:, :2], tracks.records
        near = _nearness(self.last, x, records)
        moved, A, now = self.now.moved(x, self.last, near)
        outside = ~self.now.shows(moved, records['extent'])
        leave = (outside & (records['left'] <= records['updated'])).nonzero()[0]
        if len(leave):
            off = self._off_nearness(tracks, leave, near[leave], moved[leave])
            near[leave] += off
            records['aloft'][leave] |= off != 0
            moved, A, now = self.now.moved(x, self.last, near)
            outside[leave] = ~self.now.shows(moved[leave], records['extent'][leave])
        records['nearness'] = now
        records['extent'] *= np.divide(now, near, out=np.ones(len(x)), where=near > 0)[
            :, None, None
        ]
        records['left'][outside] = self.stamp
        seen = records['visible'][outside] * SEEN_OUTSIDE
        records['hidden'][outside] += records['visible'][outside] - seen
        records['visible'][outside] = seen
        return EgoMotion(A, moved - _turned(A, x))

    def _off_nearness(
        self, tracks: TrackTable[Bank], leave: Indices, near: Floats, moved: Floats
    ) -> Floats:
        """Explain velocities of tracks, (K,), by how near their objects are, as far as they stand.

        :param near: (K,) inverse distances [1/m]; moved: (K, 2) where that takes them [px].
        :return: (K,) what is to be added to the inverse distances.
        """
        mean, cov = tracks.filters.estimate()
        nearer = self.now.moved(mean[leave, :2], self.last, near + NEARER)[0]
        slope = (nearer - moved) / NEARER / self.dt
        off = off_nearness(near, mean[leave, 2:4], cov[leave, 2:4, 2:4], slope)
        change = np.zeros((len(mean), 2))
        change[leave] = -off[:, None] * slope
        tracks.filters.accelerate(change)
        return off

    def way(self, x: Floats, records: Records) -> Floats:
        """Return the displacements that led to the present positions x, (N, 2) [px]."""
        return x - self.last.moved(x, self.now, _nearness(self.now, x, records))[0]


def _nearness(view: Viewpoint, x: Floats, records: Records) -> Floats:
    """Return the inverse distances of tracks at x, (N, 2): (N,) [1/m].

    They follow from the lower edges of objects; those out of view or off the ground keep the
    recorded value.
    """
    reach = records['extent']
    feet = x + reach[:, 1] * [0.0, 1.0]
    on_ground = view.shows(x, reach) & ~records['aloft']
    return np.where(on_ground, view.nearness(x, feet), records['nearness'])


class Camera:
    """Motion of the camera in the last frame."""

    def __init__(self) -> None:
        self._motion: EgoMotion | Turn = STANDING
        self._dt = 1.0
        self._viewpoint: Viewpoint | None = None
        self._change2, self._steady, self._alert = np.zeros(2), 0, 0.0

    @property
    def is_known(self) -> bool:
        """Whether the pose of the camera is given."""
        return self._viewpoint is not None

    def turn(self, viewpoint: Viewpoint | None, stamp: int, dt: float) -> None:
        """Advance to the next frame, taken from a given viewpoint; None: unknown.

        :param stamp: of the frame [ns].
        :param dt: since the last frame [s].
        """
        last, self._viewpoint, self._dt = self._viewpoint, viewpoint, dt
        self._motion = Turn(last, viewpoint, stamp, dt) if last and viewpoint else STANDING

    @property
    def stands(self) -> bool:
        """Whether the camera did not move."""
        return self._motion is STANDING

    @property
    def is_watched(self) -> bool:
        """Whether the camera moves, or has moved within ALERT."""
        return self._alert > 0 or not self.stands

    def follow(
        self, expected: Floats, variance: Floats, z: Floats, dt: float, find: Find = find_ego_motion
    ) -> None:
        """Advance to the next frame, and correct the motion by its detections.

        :param expected: (N, 2) positions predicted without the camera's motion, of objects measured
            in the last frame [px].
        :param variance: (N, 2) of the predictions plus the measurements [px^2].
        :param z: (M, 2) detections [px].
        :param dt: since the last frame [s].
        :param find: find_ego_motion, or find_jump for a camera that is expected to stand.
        """
        assert isinstance(self._motion, EgoMotion)
        last = self._motion.during(dt / self._dt)
        self._motion, self._dt = last, dt
        if not len(z):
            return
        moved = last.of(expected)
        change = find(moved, variance, z)
        self._steady, self._alert = self._steady + 1, self._alert - dt
        if change is not None:
            self._motion, self._steady, self._alert = change.after(last), 0, ALERT
        elif last is not STANDING:
            found, still = (count_found(x, variance, z) for x in (moved, expected))
            if 2 * found < len(expected):  # it shakes: it has stopped, or is thrown back far
                change = find(expected, variance, z)
                if change is not None:
                    self._motion, self._steady, self._alert = change, 0, ALERT
                elif still >= found:
                    self._motion = STANDING
        if len(expected) and not (self.stands and last is STANDING):
            moved = (self._motion.of(expected) - last.of(expected)).mean(axis=0) / dt
            self._change2 += (moved**2 - self._change2) / UNSTEADINESS_MEMORY

    @property
    def is_steady(self) -> bool:
        """Whether the camera moves, without a change in the last STEADY_FRAMES frames."""
        steady = not self.stands and self._steady >= STEADY_FRAMES
        return steady and not isinstance(self._motion, Turn)

    def stop(self) -> None:
        """Assume that the camera stands from now on."""
        self._motion, self._viewpoint = STANDING, None

    def give(self, tracks: TrackTable[Bank], recent: Recent, now: int) -> None:
        """Add the camera's motion to that of tracks, and move their recorded past back accordingly.

        :param recent: slots of the frames in the records.
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
        """Move tracks, with their recorded past, as the camera's motion has moved the picture."""
        if self.stands or not len(tracks):
            return
        records = tracks.records
        A, shift, variance = self._motion.take(tracks)
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
        """Add the camera's motion to the velocities of published tracks, of dtype TRACK.

        Its error is that of the detections that told it: these do not reduce it once more.

        :param tracks: all tracks.
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
        if isinstance(self._motion, EgoMotion):
            rows['covariance'][:, (0, 1), (0, 1)] += self._motion.variance

    def _way(self, tracks: TrackTable[Bank]) -> Floats:
        """Return what the camera's motion adds to the velocities of tracks, (N, 2) [px/s]."""
        x = tracks.filters.estimate()[0][:, :2]
        return self._motion.way(x, tracks.records) / self._dt


def _turned(A: Floats, x: Floats) -> Floats:
    """Return A x for vectors x, (..., 2)."""
    return np.asarray((A @ x[..., None])[..., 0])
