"""Initiation: every unassociated blob starts a tentative track."""

import numpy as np

from colortrack_ros.data import Indices
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.records import record_size
from colortrack_ros.tracking.rectangles import points_inside
from colortrack_ros.tracking.sizes import both_ways
from colortrack_ros.tracking.sizes import total
from colortrack_ros.tracking.splinters import note_hosts
from colortrack_ros.tracking.unsized import have_boxes

NEW = 0.5
"""Prior probability that an unassociated detection is an object: even odds, since nothing is known.
The detections of the next frames decide."""

MOST_NEW = 10
"""Unassociated blobs whose sizes are learned from in a frame, to bound its time. Assumed."""

FOUND_AGAIN = 0.05
"""The same for a detection inside an object that was itself detected in the frame: usually the
detector has found that object twice; if not, the next detections will tell. Assumed; with 0.02 and
0.1, IDF1 on public detections of pedestrians changes by at most 2.3 points."""


def initiate(
    tracks: TrackTable[Bank], prediction: Prediction, blobs: Measurements, new: Indices
) -> None:
    """Start a track on each of these blobs; learn from a few how well sizes tell objects apart.

    :param prediction: of the frame; it gives the priors of velocity and acceleration.
    :param new: (K,) indices of blobs.
    """
    if not len(new):
        return
    sized = have_boxes(blobs)[new]
    if np.count_nonzero(sized) and prediction.sized and len(prediction.records):
        size = total(prediction.records['extent'])
        prediction.sizes.learn_alike(size, blobs.size[new[sized][:MOST_NEW]])
    bank, z, speed, noise = tracks.filters, blobs.z[new], prediction.speed, prediction.noise
    spread = np.array([0.0, 0.0, *speed, noise, noise])
    filters = bank.at_rest(z, blobs.R[new], spread[: bank.model.size])
    records = tracks.initiate(filters, prediction.step.now)
    records['origin'] = records['seen'] = z
    records['color'] = blobs.rows['color'][new]
    records['extent'][sized] = blobs.reach(new[sized])
    records['partial'] = blobs.cut[new]
    records['stood'], records['whole'] = blobs.box[new], both_ways(blobs.size[new])
    records['emerging'] = True
    records['visible'] = NEW
    if prediction.sized:
        _note_repeated(records, prediction)
    else:
        note_hosts(records, prediction)
    record_size(records, slice(None), blobs.rows[new], z)


def _note_repeated(records: Records, prediction: Prediction) -> None:
    """Mark new tracks, (K,), that start inside an object measured in the same frame."""
    measured = (prediction.records['updated'] == prediction.step.now).nonzero()[0]
    seen, half = prediction.records['seen'][measured], prediction.size[measured] / 2
    host, repeated = points_inside(seen, half, records['origin'])
    records['visible'][repeated] = FOUND_AGAIN
    records['host'][repeated] = prediction.records['track_id'][measured[host]]
