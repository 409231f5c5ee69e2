"""Memory: deleted tracks whose objects may reappear."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.motion.constant_velocity import REFERENCE_PERIOD
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.population import Population
from colortrack_ros.tracking.prediction import process_variance

MOST_REMEMBERED = 200
"""Largest number of remembered tracks, to bound time and memory: enough, at 6 s, for a scene that
loses 33 objects a second."""


class Memory:
    """Tracks that have been unmeasured for longer than a live one may be, or have left the picture.

    What seems to have left may have been missed as it turned back at the border: it is remembered
    for as long as a live track may be unmeasured.

    :param none: an empty table with the columns of the live one.
    :param population: tracks of a color whose number of objects is known are never forgotten.
    :ivar tracks: the remembered ones, predicted to the stamp of the last call.
    """

    def __init__(self, none: TrackTable[Bank], population: Population) -> None:
        self.tracks = none
        self._population = population
        self._stamp = 0

    def remember(
        self, gone: TrackTable[Bank], stamp: int, learned: Adaptation, config: TrackerConfig
    ) -> None:
        """Add tracks, predicted to a stamp [ns]."""
        self.advance(stamp, learned, config)
        self.tracks.extend(gone)

    def advance(self, stamp: int, learned: Adaptation, config: TrackerConfig) -> None:
        """Forget tracks unmeasured for too long, and predict the others to a stamp [ns].

        The process noise learned for coasting adds to that of their filters.
        """
        dt, self._stamp = (stamp - self._stamp) / NANOSECONDS, stamp
        if not len(self.tracks):
            return
        keep = ~self.tracks.is_overdue(stamp, config.max_hidden)
        left = self.tracks.records['outside']
        keep &= ~(left & self.tracks.is_overdue(stamp, config.max_time_since_update))
        keep[:-MOST_REMEMBERED] = False
        keep |= self._population.is_counted(self.tracks.records['color'])
        self.tracks.keep(keep)
        records = self.tracks.records
        unseen = records['astray'] / REFERENCE_PERIOD
        self.tracks.filters.predict(dt, process_variance(records, learned, config) + unseen)

    def forget(self, which: NDArray[np.intp]) -> None:
        """Drop tracks, (K,) indices, that are live again."""
        self.tracks.keep(np.delete(np.arange(len(self.tracks)), which))
