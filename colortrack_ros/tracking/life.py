"""The life of a track: its records, its existence, its confirmation and its end."""

import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.measurements import Blobs

RECORD = np.dtype(
    [
        ('track_id', 'u4'),
        ('color', 'u4'),
        ('state', 'u1'),
        ('born', 'i8'),
        ('updated', 'i8'),
        ('origin', 'f8', 2),
        ('hits', 'u4'),
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
)
"""One track, besides its filter.

born, updated: stamp of the first and of the last detection [ns]; origin: where it began [px];
hits, misses: frames with and without a detection; extent: reach of the object to the low and high
side, by axis [px], see blobs; partial: it has never been in sight wholly, by axis; innovation: the
last one, see Pairs; outside: predicted outside the picture; visible, hidden: probability that the
object exists and can, or cannot, be seen.
"""

NEW = 0.5
"""Probability that a detection which belongs to no track is an object."""

COVERED_EVERY = 10.0
GONE_EVERY = 100.0
"""How long an object in sight stays so, until something covers it or it vanishes, on average [s]"""

LEAVING = 3.5
"""So many frames after it was last seen an object is taken to have left on its straight way."""


def births(blobs: Blobs, new: NDArray[np.intp], stamp: int, first_id: int) -> NDArray[np.void]:
    """Records of new tracks.

    :param blobs: of the frame.
    :param new: (K,) which of them are new.
    :param stamp: of their frame [ns].
    :param first_id: of the first one; the others follow.
    :return: (K,) of dtype RECORD.
    """
    records = np.zeros(len(new), RECORD)
    records['track_id'] = np.arange(first_id, first_id + len(new))
    records['born'] = stamp
    records['origin'] = blobs.z[new]
    records['color'] = blobs.rows['color'][new]
    records['extent'] = blobs.reach(new)
    records['partial'] = blobs.cut[new]
    records['visible'] = NEW
    hit(records, slice(None), blobs.rows[new], stamp)
    return records


def hit(
    records: NDArray[np.void], track: NDArray[np.intp] | slice, rows: NDArray[np.void], stamp: int
) -> None:
    """Note that the tracks have taken the detections rows, (K,) of dtype DETECTION."""
    records['updated'][track] = stamp
    records['hits'][track] += 1
    for name in ('area', 'box_w', 'box_h'):
        records[name][track] = rows[name]


def conceal(records: NDArray[np.void], dt: float, config: TrackerConfig) -> None:
    """Existence before the detections: what is seen gets covered or goes, what is covered returns.

    A Markov chain of the states visible, hidden, gone (Markov chain two of Musicki, Evans and
    Stankovic 1994), so that a hidden object does not stop existing by not being seen.

    :param records: (N,) of dtype RECORD.
    :param dt: [s].
    :param config: a third of its max_time_since_update is how long objects stay hidden on average.
    """
    returning = -math.expm1(-3 * dt / max(config.max_time_since_update, 1e-3))
    covered, gone = -math.expm1(-dt / COVERED_EVERY), -math.expm1(-dt / GONE_EVERY)
    visible, hidden = records['visible'].copy(), records['hidden'].copy()
    records['visible'] = visible * (1 - covered - gone) + hidden * returning
    records['hidden'] = hidden * (1 - returning) + visible * covered


def reveal(records: NDArray[np.void], ratio: NDArray[np.float64]) -> None:
    """Existence after the detections (integrated PDA; Musicki, Evans and Stankovic 1994).

    :param records: (N,) of dtype RECORD.
    :param ratio: (N,) likelihood of what was measured if the object is visible, against clutter.
    """
    visible = records['visible'] * ratio
    total = 1 + records['visible'] * (ratio - 1)
    records['visible'] = np.minimum(visible / total, 1.0)
    records['hidden'] = np.minimum(records['hidden'] / total, 1 - records['visible'])


def settle(records: NDArray[np.void], stamp: int, config: TrackerConfig) -> NDArray[np.bool_]:
    """Confirm m of n, mark as coasting, and find the tracks whose time is not over.

    :param records: (N,) of dtype RECORD.
    :param stamp: of this frame [ns].
    :param config: the limits.
    :return: (N,) True for tracks to keep.
    """
    measured = records['updated'] == stamp
    tentative = (records['state'] == TENTATIVE) & (records['hits'] < config.confirm_hits)
    records['state'] = np.where(measured, CONFIRMED, COASTING)
    records['state'][tentative] = TENTATIVE
    hopeless = records['misses'] > config.confirm_window - config.confirm_hits
    limit = round(config.max_time_since_update * NANOSECONDS)
    return (stamp - records['updated'] <= limit) & ~(tentative & hopeless)


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
