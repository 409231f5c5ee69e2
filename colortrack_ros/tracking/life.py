"""The life of a track: its records, its existence, its confirmation and its end."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.measurements import Blobs

Indices = NDArray[np.intp]

FIELDS = [
    ('color', 'u4'),
    ('origin', 'f8', 2),
    ('misses', 'u4'),
    ('area', 'f4'),
    ('box_w', 'f4'),
    ('box_h', 'f4'),
    ('extent', 'f8', (2, 2)),
    ('partial', '?', 2),
    ('innovation', 'f8', 2),
    ('outside', '?'),
    ('visible', 'f8'),
    ('hidden', 'f8'),
]
"""What is recorded of a track besides the COMMON fields.

origin: where it began [px]; misses: frames without a detection; area, box_w, box_h: of the last
detection [px]; extent: reach of the object to the low and high side, by axis [px], see blobs;
partial: it has never been in sight wholly, by axis; innovation: the last one, see Innovations;
outside: predicted outside the picture; visible, hidden: probability that the object exists and can,
or cannot, be seen.
"""

KEPT = ('track_id', 'born', 'origin', 'color', 'extent', 'partial', 'hits')
"""What a track keeps when another goes on in its place."""

NEW = 0.5
"""Probability that a detection which belongs to no track is an object."""

LEAVING = 3.5
"""So many frames after it was last seen an object is taken to have left on its straight way."""


def initiate(
    tracks: TrackTable[Bank],
    blobs: Blobs,
    new: Indices,
    stamp: int,
    speed: float,
    acceleration: float,
) -> None:
    """Begin a track on each of some blobs.

    :param new: (K,) which blobs.
    :param stamp: of their frame [ns].
    :param speed: standard deviation of their velocity on each axis [px/s].
    :param acceleration: the same of the acceleration, for models that have one [px/s^2].
    """
    bank, z = tracks.filters, blobs.z[new]
    spread = np.array([0.0, 0.0, speed, speed, acceleration, acceleration])
    filters = bank.at_rest(z, blobs.R[new], spread[: bank.model.size])
    records = tracks.initiate(filters, stamp)
    records['origin'] = z
    records['color'] = blobs.rows['color'][new]
    records['extent'] = blobs.reach(new)
    records['partial'] = blobs.cut[new]
    records['visible'] = NEW
    record_size(records, slice(None), blobs.rows[new])


def record_size(records: NDArray[np.void], track: Indices | slice, rows: NDArray[np.void]) -> None:
    """Note the sizes of the detections rows, (K,), that tracks have taken."""
    for name in ('area', 'box_w', 'box_h'):
        records[name][track] = rows[name]


def succeed(tracks: TrackTable[Bank], lost: Indices, found: Indices) -> None:
    """Let tracks, (K,), go on as what others, (K,), are; their IDs and sizes stay."""
    tracks.filters.put(lost, tracks.filters.take(found))
    records = tracks.records
    hits = records['hits'][found]
    for name in records.dtype.names or ():
        if name not in KEPT:
            records[name][lost] = records[name][found]
    records['hits'][lost] += hits


def published(tracks: TrackTable[Bank], stamp: int, bias: float) -> NDArray[np.void]:
    """The tracks as they are published, none that is outside the picture.

    :param stamp: now [ns].
    :param bias: standard deviation to add to the position on each axis [px].
    :return: of dtype TRACK.
    """
    if tracks.records['outside'].any():
        tracks = tracks.take(~tracks.records['outside'])
    mean, covariance = tracks.filters.estimate()
    rows = tracks.rows(stamp, mean[:, :4], covariance[:, :4, :4])
    rows['covariance'][:, 0, 0] += bias**2
    rows['covariance'][:, 1, 1] += bias**2
    rows['score'] = tracks.records['visible'] + tracks.records['hidden']
    return rows


def settle(tracks: TrackTable[Bank], stamp: int, config: TrackerConfig) -> NDArray[np.bool_]:
    """Confirm m of n, mark as coasting, and find the tracks whose time is not over.

    :param stamp: of this frame [ns].
    :param config: the limits.
    :return: (N,) True for tracks to keep.
    """
    tentative = tracks.update_states(stamp, config.confirm_hits)
    hopeless = tracks.records['misses'] > config.confirm_window - config.confirm_hits
    return ~tracks.is_overdue(stamp, config.max_time_since_update) & ~(tentative & hopeless)


def present(
    records: NDArray[np.void],
    mean: NDArray[np.float64],
    cov: NDArray[np.float64],
    stamp: int,
    dt: float,
    config: TrackerConfig,
) -> NDArray[np.bool_]:
    """Find the tracks of which it is known where they are, and mark those outside the picture.

    Outside is what, unmeasured, is predicted there wholly, by more than a standard deviation. If
    it was seen up to a few frames ago and does not come back it has left. Had it been hidden
    before, it may be still inside.

    :param records: (N,) of dtype RECORD.
    :param mean, cov: (N, n) and (N, n, n) estimates.
    :param stamp: of this frame [ns].
    :param dt: since the last frame [s].
    :param config: the limits.
    :return: (N,) True for tracks to keep.
    """
    largest = np.maximum(cov[:, 0, 0], cov[:, 1, 1])
    keep = largest <= config.max_position_sigma**2
    records['outside'] = False
    if not all(config.image_size):
        return keep
    last = np.array(config.image_size) - 0.5
    beside = ((mean[:, :2] < -0.5) | (mean[:, :2] > last)).any(axis=1)
    track = np.flatnonzero(beside & (records['updated'] != stamp))
    if len(track):
        sigma = np.sqrt(cov[track][:, [0, 1], [0, 1]])
        reach, center, velocity = records['extent'][track], mean[track, :2], mean[track, 2:4]
        before = center + reach[:, 1] + sigma < -0.5
        beyond = center - reach[:, 0] - sigma > last
        outside = (before | beyond).any(axis=1)
        records['outside'][track] = outside
        leaving = (before & (velocity <= 0)) | (beyond & (velocity >= 0))
        recent = stamp - records['updated'][track] < LEAVING * dt * NANOSECONDS
        keep[track] &= ~(outside & leaving.any(axis=1) & recent)
    return keep
