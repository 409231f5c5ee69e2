"""Objects: their tracks, their properties, and their estimated states."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.data import Bools
from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.belief import Belief
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.settling import settle
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View


@dataclass
class Objects(Columns):
    """Table of objects, one per row, seen by C cameras.

    :ivar object_id, color: (N,).
    :ivar track_id: (N, C) ID of the linked track of each camera, 0 for none.
    :ivar states, scores: (N, C) of these tracks, 0 for none.
    :ivar updates: (N, C) time of each camera's last accepted measurement [ns].
    :ivar belief: states of the objects, and errors of the cameras.
    :ivar kinds: known properties.
    """

    object_id: NDArray[np.int64]
    color: NDArray[np.int64]
    track_id: NDArray[np.int64]
    states: NDArray[np.uint8]
    scores: Floats
    updates: NDArray[np.int64]
    belief: Belief
    kinds: Kinds

    @classmethod
    def none(cls, kinds: Kinds, cameras: int, belief: Belief) -> 'Objects':
        """Create an empty table."""
        ids = np.zeros(0, np.int64)
        return cls.begun(ids, ids, cameras, belief, kinds.take(ids))

    @classmethod
    def begun(
        cls,
        ids: NDArray[np.int64],
        colors: NDArray[np.int64],
        cameras: int,
        belief: Belief,
        kinds: Kinds,
    ) -> 'Objects':
        """Create a table of objects, (N,), that are not linked to tracks yet."""
        each = np.zeros((len(ids), cameras), np.int64)
        scores = each.astype(float)
        return cls(ids, colors, each, each.astype(np.uint8), scores, each.copy(), belief, kinds)

    @property
    def state(self) -> NDArray[np.uint8]:
        """Best state over the cameras, (N,)."""
        coasting = (self.states == COASTING).any(axis=1) * COASTING
        return np.where((self.states == CONFIRMED).any(axis=1), CONFIRMED, coasting).astype(
            np.uint8
        )

    @property
    def score(self) -> Floats:
        """Highest score over the cameras, (N,)."""
        return np.asarray(self.scores.max(axis=1, initial=0.0))

    @property
    def updated(self) -> NDArray[np.int64]:
        """Time of the last measurement, (N,) [ns]."""
        return np.asarray(self.updates.max(axis=1, initial=0))

    def follow(self, tracks: NDArray[np.void], camera: int) -> None:
        """Update from the tracks of a camera, and drop objects without a track of any camera.

        :param tracks: all of the camera, of dtype TRACK, ascending.
        """
        own, ids = self.track_id[:, camera], tracks['track_id'].astype(np.int64)
        at = np.searchsorted(ids, own)
        there = np.append(ids, -1)[at] == own
        if np.count_nonzero(there) < len(there):
            self.unlink(np.flatnonzero(~there), camera)
        at = at[there]
        self.states[there, camera] = tracks['state'][at]
        self.scores[there, camera] = tracks['score'][at]
        left = np.asarray(self.track_id.any(axis=1))
        if np.count_nonzero(left) < len(left):
            settle(self.belief, self.kinds, ~left)
            self.keep(np.flatnonzero(left))

    def link(self, rows: Indices, tracks: NDArray[np.void], camera: int, stamp: int) -> None:
        """Link tracks of a camera, (K,), to objects that it has just measured, (K,)."""
        self.track_id[rows, camera] = tracks['track_id']
        self.states[rows, camera] = tracks['state']
        self.scores[rows, camera] = tracks['score']
        self.updates[rows, camera] = stamp

    def unlink(self, rows: Indices, camera: int) -> None:
        """Remove the links of objects, (K,), to tracks of a camera."""
        self.track_id[rows, camera], self.states[rows, camera] = 0, 0
        self.scores[rows, camera] = 0.0

    def kick(
        self,
        refused: Bools,
        measured: Measured,
        view: View,
        ground: float,
        camera: int,
        times: tuple[int, int],
    ) -> Bools:
        """Treat objects refused twice in a row as kicked, if that fits their measurements.

        :param refused: (N,); measured: N.
        :param times: of the camera's last picture, and of this one [ns].
        :return: (N,) which measurements remain refused.
        """
        updated, kinds = self.updated, self.kinds
        may = refused & (updated < times[0]) & kinds.speed.any(axis=1) & ~kinds.falls
        may &= self.belief.in_front(view)
        if not may.any():
            return refused
        since = (times[1] - updated) / NANOSECONDS
        (rows,) = self.belief.kick(may, since, measured, view, kinds, ground, camera).nonzero()
        again = Measured.none(len(self))
        again.put(rows, measured.take(rows))
        still = self.belief.update(again, view, kinds, ground, camera)
        refused = refused.copy()
        refused[rows] = still[rows]
        return refused
