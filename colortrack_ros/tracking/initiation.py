"""Initiation: a track begins on every blob that belongs to none."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.records import record_size
from colortrack_ros.tracking.splinters import note_hosts

Indices = NDArray[np.intp]

NEW = 0.5
"""Prior probability that a detection which belongs to no track is an object: not known, so even
odds. The detections of the next frames decide."""


def initiate(
    tracks: TrackTable[Bank], prediction: Prediction, blobs: Measurements, new: Indices
) -> None:
    """Begin a track on each of some blobs.

    :param prediction: of the frame: how fast new objects are, and how unsteady.
    :param new: (K,) which blobs.
    """
    if not len(new):
        return
    bank, z, speed, noise = tracks.filters, blobs.z[new], prediction.speed, prediction.noise
    spread = np.array([0.0, 0.0, *speed, noise, noise])
    filters = bank.at_rest(z, blobs.R[new], spread[: bank.model.size])
    records = tracks.initiate(filters, prediction.step.now)
    records['origin'] = records['seen'] = z
    records['color'] = blobs.rows['color'][new]
    records['extent'] = blobs.reach(new)
    records['partial'] = blobs.cut[new]
    records['visible'] = NEW
    note_hosts(records, prediction)
    record_size(records, slice(None), blobs.rows[new])
