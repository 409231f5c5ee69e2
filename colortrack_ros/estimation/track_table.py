"""The live tracks: filters and records row by row, from initiation to deletion."""

from typing import Generic
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.data import Bools
from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import TRACK
from colortrack_ros.data import TRACK_BOX
from colortrack_ros.estimation.records import Fields
from colortrack_ros.estimation.records import Records

COMMON = [('track_id', 'u4'), ('state', 'u1'), ('born', 'i8'), ('updated', 'i8'), ('hits', 'u4')]
"""Fields that every tracker records.

born, updated: stamps of the first and the last measurement [ns]; hits: number of measurements;
state: TENTATIVE, CONFIRMED or COASTING.
"""

Filters = TypeVar('Filters', bound=Columns)


def rows_of(records: Records, track_id: NDArray[np.uint32]) -> tuple[Indices, Bools]:
    """Find tracks by their IDs, (K,): their rows, and which of them are there.

    :param records: (N,), at least one, with ascending IDs.
    :return: (K,) rows, any for a track that is gone, and (K,).
    """
    ids = records['track_id']
    row = np.minimum(ids.searchsorted(track_id), len(ids) - 1)
    return row, ids[row] == track_id


def marked(rows: Indices, count: int) -> Bools:
    """A mask, (count,), of some rows."""
    mask = np.zeros(count, bool)
    mask[rows] = True
    return mask


class TrackTable(Columns, Generic[Filters]):
    """N live tracks.

    :param filters: an empty bank; its rows are those of the table.
    :param fields: further fields to record, names and types as for np.dtype.
    :param next_id: ID of the next track.
    :ivar records: N rows with the COMMON fields and these.
    """

    def __init__(self, filters: Filters, fields: Fields = (), next_id: int = 1) -> None:
        self.filters = filters
        self.records = Records([*COMMON, *fields])
        self.next_id = next_id
        self._published = set(TRACK.names or ()) & set(self.records.names)
        self._has_corner = 'corner' in self.records.names

    def __len__(self) -> int:
        return len(self.records)

    def initiate(self, filters: Filters, stamp: int) -> Records:
        """Initiate tentative tracks with one measurement each.

        :param filters: of the new tracks.
        :param stamp: of their frame [ns].
        :return: a view of their records, to be filled in.
        """
        count, first = len(filters), len(self)
        self.records = self.records.grown(count)
        new = self.records.part(slice(first, None))
        new['track_id'] = np.arange(self.next_id, self.next_id + count)
        new['born'] = new['updated'] = stamp
        new['hits'], new['state'] = 1, TENTATIVE
        self.next_id += count
        self.filters.extend(filters)
        return new

    def record_hits(self, track: Indices | Bools | slice, stamp: int) -> None:
        """Record a measurement of tracks (indices, mask or slice) at the stamp [ns]."""
        self.records['updated'][track] = stamp
        self.records['hits'][track] += 1

    def update_states(self, stamp: int, confirm_hits: int) -> Bools:
        """Confirm tracks, and mark confirmed ones without a measurement as coasting.

        :param stamp: of this frame [ns].
        :param confirm_hits: measurements needed to confirm a track.
        :return: (N,) which are still tentative.
        """
        records = self.records
        tentative = (records['state'] == TENTATIVE) & (records['hits'] < confirm_hits)
        records['state'] = np.where(records['updated'] == stamp, CONFIRMED, COASTING)
        records['state'][tentative] = TENTATIVE
        return np.asarray(tentative)

    def unmeasured(self, stamp: int) -> Floats:
        """Time since the last measurement of each, (N,) [s]."""
        since: Floats = (stamp - self.records['updated']) / NANOSECONDS
        return since

    def is_overdue(self, stamp: int, longest: float) -> Bools:
        """Which were last measured more than that long ago, (N,).

        :param stamp: now [ns].
        :param longest: [s].
        """
        overdue: Bools = stamp - self.records['updated'] > round(longest * NANOSECONDS)
        return overdue

    def freshness(self, stamp: int, longest: float) -> Floats:
        """Falls from 1 for what is measured now to 0 for what was last measured longest [s] ago."""
        return np.clip(1 - self.unmeasured(stamp) / max(longest, 1e-3), 0, 1)

    def rows(self, stamp: int, mean: Floats, covariance: Floats) -> NDArray[np.void]:
        """The tracks in their published form, (N,) of dtype TRACK.

        Fields are filled from records of the same name; the others are 0. The box's corner is
        recorded relative to the position; otherwise the box is centered on it.

        :param stamp: now [ns].
        :param mean: (N, 4) u, v [px], du, dv [px/s].
        :param covariance: (N, 4, 4) of mean.
        """
        records, count = self.records, len(self.records)
        doubles = np.zeros((count, TRACK.itemsize // 8))
        rows = np.ndarray(count, TRACK, doubles)
        doubles[:, :4], doubles[:, 4:20] = mean, covariance.reshape(-1, 16)
        for name in self._published:
            rows[name] = records[name]
        box = rows.view(TRACK_BOX)
        if self._has_corner:
            box['size'], corner = records['box_size'], records['corner']
        else:
            corner = (1 - box['size']) / 2
        np.add(doubles[:, :2], corner, out=box['corner'], casting='same_kind')
        rows['age'] = (stamp - records['born']) / NANOSECONDS
        rows['time_since_update'] = self.unmeasured(stamp)
        return rows


def is_inside(position: Floats, height: int, width: int) -> Bools:
    """Which positions, (N, 2) [px], are in a picture, (N,)."""
    inside = (position >= -0.5) & (position < [width - 0.5, height - 0.5])
    return np.asarray(inside.all(axis=1))
