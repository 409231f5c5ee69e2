"""Recent positions of each track."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Tracks

TRAIL_LENGTH = 50
"""Positions kept of each track (Pegoretti 2021, Figure 24)."""


class Trails:
    """The last positions of live tracks.

    :ivar ids: (N,) ascending track IDs.
    :ivar points: (N, TRAIL_LENGTH, 2) u, v [px], oldest first; NaN before the first position.
    """

    def __init__(self) -> None:
        self.ids: NDArray[np.uint32] = np.zeros(0, np.uint32)
        self.points: NDArray[np.float64] = np.zeros((0, TRAIL_LENGTH, 2))
        self._ages: NDArray[np.float32] = np.zeros(0, np.float32)

    def update(self, tracks: Tracks) -> None:
        """Add the position of each track, and forget the tracks that are gone.

        One that is younger than before is another: its tracker has been started again.
        """
        rows = tracks.rows
        points = np.full((len(rows), TRAIL_LENGTH, 2), np.nan)
        _, old, new = np.intersect1d(self.ids, rows['track_id'], return_indices=True)
        same = rows['age'][new] >= self._ages[old]
        old, new = old[same], new[same]
        points[new, :-1] = self.points[old, 1:]
        points[:, -1, 0] = rows['u']
        points[:, -1, 1] = rows['v']
        self.ids, self.points = rows['track_id'].copy(), points
        self._ages = rows['age'].copy()
