"""Initiation of targets: areas that are unassigned in two frames."""

from dataclasses import dataclass

import numpy as np

from colortrack_ros.columns import Columns
from colortrack_ros.contours.areas import Areas
from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS


@dataclass(frozen=True)
class Candidates(Columns):
    """K areas found in two frames.

    :ivar areas: those of the later frame.
    :ivar velocity: (K, 2) velocities of their centroids [px/s].
    """

    areas: Areas
    velocity: Floats


class Initiation:
    """Nearest-neighbor correspondence of two frames (De Bem 2007, 5.3)."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget the last frame."""
        self._before, self._stamp = Areas.none(), 0

    def candidates(self, areas: Areas, stamp: int) -> Candidates:
        """Return areas that are each other's nearest in two frames, within their size.

        :param areas: the unassigned ones.
        :param stamp: of their frame [ns].
        """
        before, seconds = self._before, (stamp - self._stamp) / NANOSECONDS
        self._before, self._stamp = areas, stamp
        if not len(areas) or not len(before) or seconds <= 0:
            return Candidates(areas.take(np.zeros(0, int)), np.zeros((0, 2)))
        gap = np.linalg.norm(areas.center[:, None] - before.center, axis=2)
        nearest = gap.argmin(axis=1)
        mutual = gap.argmin(axis=0)[nearest] == np.arange(len(gap))
        mutual &= gap.min(axis=1) <= np.sqrt(areas.size)
        velocity = (areas.center - before.center[nearest]) / seconds
        return Candidates(areas, velocity).take(mutual)
