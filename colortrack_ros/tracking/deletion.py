"""Confirmation and deletion of tracks."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.config import TrackerConfig

LEAVING = 3.5
"""An object predicted outside the picture this many frames after its last detection is assumed to
have left. A visible one, detected in 95 % of the frames, is missed three times in a row once in
8000."""


def go_on(tracks: TrackTable[Bank], stamp: int, config: TrackerConfig) -> bool:
    """Confirm all tracks if each was confirmed before and is measured now; return whether.

    :param stamp: of this frame [ns].
    :param config: the limits.
    """
    records, limit = tracks.records, config.max_position_sigma**2
    sure = (records['updated'] == stamp) & (records['state'] != TENTATIVE)
    if np.count_nonzero(sure) < len(records):
        return False
    variance = tracks.filters.estimate()[1].diagonal(axis1=1, axis2=2)[:, :2]
    if np.maximum.reduce(variance, None, initial=0) > limit:
        return False
    records['state'], records['outside'] = CONFIRMED, False
    return True


def confirm(tracks: TrackTable[Bank], stamp: int, config: TrackerConfig) -> NDArray[np.bool_]:
    """Confirm by m of n, mark coasting tracks, and find those that are not to be deleted.

    :param stamp: of this frame [ns].
    :param config: the limits.
    :return: (N,) True for tracks to keep.
    """
    tentative = tracks.update_states(stamp, config.confirm_hits)
    hopeless = tracks.records['misses'] > config.confirm_window - config.confirm_hits
    overdue = tracks.is_overdue(stamp, config.max_time_since_update)
    if np.count_nonzero(overdue):
        since = (stamp - tracks.records['shared']) / NANOSECONDS
        overdue &= since > config.max_time_since_update
    return ~overdue & ~(tentative & hopeless)


def is_present(
    tracks: TrackTable[Bank],
    stamp: int,
    dt: float,
    image_size: tuple[int, int],
    config: TrackerConfig,
) -> NDArray[np.bool_]:
    """Find the tracks whose position is known well enough, and mark those outside the picture.

    An unmeasured track is outside if all of its object is predicted there, by more than a standard
    deviation. If it was seen up to a few frames ago and moves away, it has left; if it was hidden
    before, it may still be inside.

    :param stamp: of this frame [ns].
    :param dt: since the last frame [s].
    :param image_size: of the picture [px]; 0 if unknown.
    :param config: the limits.
    :return: (N,) True for tracks to keep.
    """
    records, (mean, cov) = tracks.records, tracks.filters.estimate()
    largest = np.maximum(cov[:, 0, 0], cov[:, 1, 1])
    keep = largest <= config.max_position_sigma**2
    records['outside'] = False
    if not all(image_size):
        return keep
    last = np.array(image_size) - 0.5
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
