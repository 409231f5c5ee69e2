"""Hidden rivals: tracks that were out of sight together, and may come back as each other.

Behind one cover either may turn, so where objects come out does not say who is who. Their sizes do,
once all of each is in sight: until then the decision is deferred, see crossings.
"""

import numpy as np
from scipy.spatial import cKDTree

from colortrack_ros.data import Bools
from colortrack_ros.data import Indices
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import rows_of
from colortrack_ros.tracking.measurements import either_axis
from colortrack_ros.tracking.prediction import Prediction

MEETING_SIGMAS = 2.0
"""Standard deviations of the ways of two tracks within which they may have met: 86 % of those that
have are. Derived from the Rayleigh distribution."""

OTHER_COLOR = 1e9
"""Distance of neighboring colors in the search for the nearest track of the same one [px]: more
than any two tracks may be apart. Chosen."""


def rivals(records: Records) -> tuple[Indices, Bools]:
    """The rows of the rivals of tracks, (N,), and which have none, or one that is gone, (N,).

    The rows of those that have none are any.
    """
    row, there = rows_of(records, records['rival'])
    return row, ~there | (records['rival'][row] != records['track_id'])


def remember_hidden(records: Records, prediction: Prediction, hits: int) -> None:
    """Make rivals of tracks of which one is hidden, the other, too, or cut by what may hide both.

    :param hits: least number of detections of either.
    """
    stamp = prediction.step.now
    unseen = records['updated'] < stamp
    known = (records['state'] != TENTATIVE) & (records['hits'] >= hits)
    known &= (prediction.size[:, 0] > 0) & ~records['outside']
    known &= records['left'] <= records['updated']  # a known turn takes away, but hides nothing
    cut = either_axis(records['box_size'] < prediction.size - prediction.slack)
    hidden, (row, free) = known & (unseen | cut), rivals(records)
    lost = hidden & free & (records['met'] <= records['updated'])
    _keep_what_was(records, prediction, lost.nonzero()[0])
    undecided = hidden & hidden[row] & (records['scans'] == 0)
    one, other = _may_have_met(prediction, (hidden & (free | undecided)).nonzero()[0])
    some = unseen[one] | unseen[other]
    one, other = one[some], other[some]
    records['rival'][one], records['apart'][one] = records['track_id'][other], stamp
    records['sums'][one] = records['scans'][one] = records['size_log_ratio'][one] = 0


def _keep_what_was(records: Records, prediction: Prediction, lost: Indices) -> None:
    """Keep the states and sizes of tracks that are lost or cut just now."""
    if len(lost):
        mean, cov = prediction.bank.estimate()
        records['met'][lost] = prediction.step.now
        records['before_size'][lost] = prediction.size[lost]
        records['before'][lost], records['before_cov'][lost] = mean[lost, :4], cov[lost, :4, :4]


def _may_have_met(prediction: Prediction, hidden: Indices) -> tuple[Indices, Indices]:
    """Pairs of hidden tracks, (K,), each the other's nearest of its color, that may have met.

    Either may have turned as soon as it was out of sight. Pairs are both ways round.
    """
    if len(hidden) < 2:
        return hidden[:0], hidden[:0]
    away = OTHER_COLOR * prediction.records['color'][hidden]
    place = np.column_stack([prediction.center[hidden], away])
    apart, near = (column[:, 1] for column in cKDTree(place).query(place, 2))
    turn = prediction.turn_speed(hidden) * prediction.unseen[hidden, None]
    variance = (prediction.variance[hidden] + turn * turn).mean(axis=1)
    k = np.arange(len(hidden))
    met = (near[near] == k) & (near != k)
    met &= apart < MEETING_SIGMAS * np.sqrt(variance + variance[near])
    return hidden[met], hidden[near[met]]
