"""The live tracks: their filters and their records, row by row."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TRACK
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.motion import MotionModel
from colortrack_ros.tracking.life import births
from colortrack_ros.tracking.life import RECORD
from colortrack_ros.tracking.measurements import Blobs

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

KEPT = ('track_id', 'born', 'origin', 'color', 'extent', 'partial', 'hits')
"""What a track keeps when another goes on in its place."""


class TrackTable:
    """N tracks.

    :param model: how they move.
    :param next_id: ID of the next one.
    """

    def __init__(self, model: MotionModel, next_id: int) -> None:
        self.bank = Bank(model)
        self.records = np.zeros(0, RECORD)
        self.next_id = next_id

    def append(
        self, blobs: Blobs, new: Indices, stamp: int, speed: float, acceleration: float
    ) -> None:
        """Start a track on each of some blobs.

        :param new: (K,) which blobs.
        :param stamp: of their frame [ns].
        :param speed: standard deviation of their velocity on each axis [px/s].
        :param acceleration: the same of the acceleration, for models that have one [px/s^2].
        """
        spread = np.array([0.0, 0.0, speed, speed, acceleration, acceleration])
        self.bank.append(blobs.z[new], blobs.R[new], spread[: self.bank.model.size])
        born = births(blobs, new, stamp, self.next_id)
        self.records = np.concatenate([self.records, born], dtype=RECORD)
        self.next_id += len(born)

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Drop the tracks where mask, (N,), is False."""
        self.bank.keep(mask)
        self.records = self.records[mask]

    def succeed(self, lost: Indices, found: Indices) -> None:
        """Let tracks, (K,), go on as what others, (K,), are; their IDs and sizes stay."""
        self.bank.succeed(lost, found)
        hits = self.records['hits'][found]
        for name in RECORD.names or ():
            if name not in KEPT:
                self.records[name][lost] = self.records[name][found]
        self.records['hits'][lost] += hits

    def published(self, stamp: int, bias: float) -> NDArray[np.void]:
        """The tracks as they are published, none that is outside the picture.

        :param stamp: now [ns].
        :param bias: standard deviation to add to the position on each axis [px].
        :return: of dtype TRACK.
        """
        records, (mean, covariance) = self.records, self.bank.estimate()
        if records['outside'].any():
            inside = ~records['outside']
            records, mean, covariance = records[inside], mean[inside], covariance[inside]
        rows = np.zeros(len(records), TRACK)
        for name in ('track_id', 'color', 'state', 'hits', 'area', 'box_w', 'box_h'):
            rows[name] = records[name]
        rows['u'], rows['v'], rows['du'], rows['dv'] = mean[:, :4].T
        rows['covariance'] = covariance[:, :4, :4]
        rows['covariance'][:, 0, 0] += bias**2
        rows['covariance'][:, 1, 1] += bias**2
        rows['age'] = (stamp - records['born']) / NANOSECONDS
        rows['time_since_update'] = (stamp - records['updated']) / NANOSECONDS
        rows['score'] = records['visible'] + records['hidden']
        return rows
