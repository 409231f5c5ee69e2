"""Splinters: pieces of a broken object tracked as objects.

A pole in front of a disc splits it into two detections. The piece that no track takes may start one
of its own, in particular without sizes (see merge_split), which merges with the object's when the
disc is whole again. Its history tells it from an object that met another: that one came from afar.
"""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import rows_of
from colortrack_ros.tracking.prediction import LAST_FRAME
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.rectangles import nearest_points

AWAY = 2.0
"""Ratio of the largest distance of a track from the one beside which it started to that at their
merger, above which it is an object of its own. Assumed: pieces stay within the object's outline."""

LONGEST_PIECE = 1.0
"""Time after which a track is an object of its own [s]. Assumed: with half of it, IDF1 is the same
for pieces and for pairs that hover where they merge; with twice, such pairs lose 10 points."""

SPLINTER_FIELDS = [
    ('host', 'u4'),
    ('farthest', 'f8'),
    ('apart_last', 'f8'),
    ('noted', 'i8'),
    ('splinter', '?'),
]
"""Splinter fields of a track: ID of the confirmed track beside which it started (with boxes, inside
which it started, see initiation), 0 for none; the largest distance between the two so far, and that
when both were last seen [px]; stamp of its start [ns]; and whether it has counted as a piece since
it was last seen alone."""


def note_hosts(records: Records, prediction: Prediction) -> None:
    """Record beside which track each new one starts.

    :param records: (K,) of the new tracks.
    """
    known = prediction.records['state'] != TENTATIVE
    known &= prediction.unmeasured < LAST_FRAME * prediction.step.period
    hosts = known.nonzero()[0]
    if not len(hosts):
        return
    nearest = hosts[nearest_points(prediction.center[hosts], records['origin'])]
    away = records['origin'] - prediction.center[nearest]
    records['host'] = prediction.records['track_id'][nearest]
    records['farthest'] = records['apart_last'] = np.hypot(away[:, 0], away[:, 1])
    records['noted'] = prediction.step.now


def find_hosts(prediction: Prediction, reach: float) -> Indices:
    """Find the tracks that have never been far from the one beside which they started.

    :param reach: distance beyond which nothing merges, see Resolution [px].
    :return: (N,) rows of the tracks beside which they started, -1 for objects of their own.
    """
    records = prediction.records
    host = np.full(len(records), -1)
    begun = records['host'].nonzero()[0]
    if not len(begun):
        return host
    records['splinter'] &= prediction.unseen > LAST_FRAME * prediction.step.period
    row, there = rows_of(records, records['host'][begun])
    there &= row != begun
    begun, row = begun[there], row[there]
    both = np.maximum(prediction.unseen[begun], prediction.unseen[row])
    seen = (both < LAST_FRAME * prediction.step.period).nonzero()[0]
    away = records['seen'][begun[seen]] - records['seen'][row[seen]]
    apart = np.hypot(away[:, 0], away[:, 1])
    records['apart_last'][begun[seen]] = apart
    records['farthest'][begun[seen]] = np.maximum(records['farthest'][begun[seen]], apart)
    farthest = records['farthest'][begun]
    seen_for = (records['updated'][begun] - records['noted'][begun]) / NANOSECONDS
    records['host'][begun[(farthest > AWAY * reach) | (seen_for > LONGEST_PIECE)]] = 0
    near = farthest <= AWAY * records['apart_last'][begun]
    near &= seen_for <= LONGEST_PIECE
    host[begun[near]] = row[near]
    return host


def leave_out_splinters(records: Records, member: Indices, host: Indices) -> Indices:
    """Record and remove the splinters in sets of tracks that share a detection.

    :param member: (S, n) tracks, -1 after the last.
    :param host: (N,) see find_hosts().
    :return: (S, n) as member.
    """
    of = np.where(member >= 0, host[member], -1)
    splinter = (of >= 0) & (of[:, :, None] == member[:, None]).any(axis=2)
    splinter[:, 0] &= ~splinter.all(axis=1, where=member >= 0)
    records['splinter'][member[splinter]] = True
    left = np.where(splinter, -1, member)
    order = np.argsort(left < 0, axis=1, kind='stable')
    return np.take_along_axis(left, order, axis=1)


def mark_pieces(
    prediction: Prediction, lost: Indices, track: Indices, owner: NDArray[np.uint32]
) -> Bools:
    """Find the splinters among tracks that would share a blob with sizes, and record them.

    :param lost: tracks without a blob, (L,).
    :param track: (K,) those of them that would share one.
    :param owner: (K,) ID of the track that has taken it.
    :return: (K,) whether it started inside the owner's object, and shortly before.
    """
    records, step = prediction.records, prediction.step
    records['splinter'][lost] &= prediction.unseen[lost] > LAST_FRAME * step.period
    piece = records['host'][track] == owner
    piece &= step.now - records['born'][track] < LONGEST_PIECE * NANOSECONDS
    records['splinter'][track[piece]] = True
    return np.asarray(piece)
