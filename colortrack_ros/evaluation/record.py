"""Tracks or ground truth: what was where in each frame."""

from collections.abc import Iterable
from dataclasses import dataclass
from dataclasses import field
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import COASTING
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import TRACK_BOX
from colortrack_ros.data import Tracks
from colortrack_ros.scenes import Scene

ROW = np.dtype(
    [
        ('frame', 'i8'), ('stamp', 'i8'), ('id', 'i8'), ('u', 'f8'), ('v', 'f8'), ('w', 'f8'),
        ('h', 'f8'), ('visible', 'f8'), ('du', 'f8'), ('dv', 'f8'), ('covariance', 'f8', (4, 4)),
        ('coasting', '?'), ('middle', 'f8', 2),
    ]
)  # fmt: skip
"""One object or track in one frame.

frame: from 0; stamp: of the frame [ns], -1: unknown; u, v: center [px]; w, h: box [px]; visible:
visible share, 0..1; du, dv: velocity [px/s]; covariance: of (u, v, du, dv); coasting: not measured
in this frame; middle: of the box, if that is not the center [px]. NaN: unknown.
"""


@dataclass(frozen=True)
class Record:
    """Rows of all frames, in the order of the frames.

    :param rows: (N,) of dtype ROW.
    :param frames: (F,) all frames, ascending, including those without rows.
    :param delays: (F,) from the stamp of each frame to the recording of its tracks [s], or empty.
    :param stamps: (F,) of each frame [ns], or empty.
    :param conditions: further facts about the recording, such as the measurement noise.
    :param said: warnings of its nodes, and for how many seconds each was active.
    """

    rows: NDArray[np.void]
    frames: NDArray[np.int64]
    delays: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    stamps: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    conditions: dict[str, float] = field(default_factory=dict)
    said: dict[str, int] = field(default_factory=dict)

    @classmethod
    def of(cls, rows: NDArray[np.void], frames: Iterable[int] | None = None) -> 'Record':
        """A record with its rows sorted by frame.

        :param frames: None: the frames that have rows.
        :raises ValueError: an ID is in a frame twice, for which no measure is defined.
        """
        once = rows[np.lexsort((rows['id'], rows['frame']))][['frame', 'id']]
        if (twice := once[1:][once[1:] == once[:-1]]).size:
            frame, name = twice[0]
            told = f'got ID {name} twice in frame {frame}, counted from 0'
            raise ValueError(f'expected each ID once in a frame, {told}')
        rows = rows[np.argsort(rows['frame'], kind='stable')]
        known = rows['frame'] if frames is None else np.fromiter(frames, np.int64)
        return cls(rows, np.unique(known))

    def numbered_as(self, other: 'Record') -> 'Record | None':
        """The same rows with the frame numbers that another record has at their stamps.

        Where a node has skipped pictures, message n is not of picture n.

        :param other: the frames that it does not have are left out.
        :return: None if stamps do not tell: unknown, ambiguous, or all different.
        """
        order = np.argsort(other.stamps)
        stamps, frames = other.stamps[order], other.frames[order]
        if (
            not len(stamps)
            or (np.diff(stamps) == 0).any()
            or (self.rows['stamp'] < 0).any()
            or (np.diff(self.rows['stamp']) < 0).any()
        ):
            return None
        at = np.minimum(np.searchsorted(stamps, self.rows['stamp']), len(stamps) - 1)
        known = stamps[at] == self.rows['stamp']
        if not known.any():
            return None
        rows = self.rows[known].copy()
        rows['frame'] = frames[at][known]
        record = Record.of(rows, other.frames.tolist())
        return replace(self, rows=record.rows, frames=record.frames, stamps=other.stamps)

    def rows_of(self, frame: int) -> NDArray[np.void]:
        """The rows of one frame."""
        first, last = np.searchsorted(self.rows['frame'], [frame, frame + 1])
        return self.rows[first:last]


def empty_rows(count: int) -> NDArray[np.void]:
    """Rows with all values unknown."""
    rows = np.zeros(count, ROW)
    for name in ('u', 'v', 'w', 'h', 'du', 'dv', 'covariance', 'middle'):
        rows[name] = np.nan
    rows['stamp'], rows['visible'] = -1, 1.0
    return rows


def rows_of_tracks(tracks: Tracks, frame: int) -> NDArray[np.void]:
    """The confirmed and the coasting tracks of a frame."""
    shown = tracks.rows[tracks.rows['state'] != TENTATIVE]
    rows = empty_rows(len(shown))
    for name in ('u', 'v', 'du', 'dv', 'covariance'):
        rows[name] = shown[name]
    rows['id'], rows['w'], rows['h'] = shown['track_id'], shown['box_w'], shown['box_h']
    box = shown.view(TRACK_BOX)
    rows['middle'] = box['corner'] + (box['size'] - 1) / 2
    rows['frame'], rows['stamp'] = frame, tracks.stamp
    rows['coasting'] = shown['state'] == COASTING
    return rows


def record_of_scene(scene: Scene) -> Record:
    """The ground truth of a scene."""
    parts = []
    for k in range(len(scene)):
        truth = scene.truth(k)
        rows = empty_rows(len(truth))
        for name in ('id', 'u', 'v', 'visible'):
            rows[name] = truth[name]
        rows['w'] = rows['h'] = 2 * truth['radius']
        rows['frame'] = k
        parts.append(rows)
    return Record.of(np.concatenate([*parts, empty_rows(0)]), range(len(scene)))
