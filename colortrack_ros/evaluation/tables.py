"""Reads tracks and truth from text: CSV written by replay, MOTChallenge, CSV of truth."""

from collections.abc import Mapping
import csv
import io
import itertools
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import COASTING
from colortrack_ros.data import CORNER
from colortrack_ros.data import TENTATIVE
from colortrack_ros.evaluation.record import empty_rows
from colortrack_ros.evaluation.record import Record
from colortrack_ros.files import open_file

TRUTH_COLUMNS = ('frame', 'id', 'u', 'v')
TRACK_COLUMNS = ('frame', 'track_id', 'state', 'u', 'v', 'du', 'dv', 'box_w', 'box_h', 'stamp')
MOT_COLUMNS = 6
"""frame, id, left, top, width, height; further columns are ignored."""

STATE_COLUMNS = ('u', 'v', 'du', 'dv')


class RecordError(Exception):
    """A file is not what was expected; says which file, and what was expected."""


def read_record(path: Path) -> Record:
    """Tracks or truth.

    A ``.txt`` is MOTChallenge, whose frames and pixels count from 1. A ``.csv`` has the columns
    that ``replay --csv`` writes (frames from 1), or frame (from 0), id, u, v, and optionally w, h
    and visible. Beside a truth ``NAME.csv``, a file ``NAME.frames`` lists the frames, one a line,
    in which every object is labeled; only these are evaluated.

    :raises RecordError: it is none of these.
    """
    try:
        if path.suffix == '.txt':
            return _of_mot(path)
        with open_file(path) as file:
            lines = csv.DictReader(io.TextIOWrapper(file, newline=''))
            names = set(lines.fieldnames or ())
            columns: Mapping[str, list[float]] = {name: [] for name in names}
            for line in lines:
                for name in names:
                    columns[name].append(float(line[name]))
        table = {name: np.array(values) for name, values in columns.items()}
        if names.issuperset(TRACK_COLUMNS):
            return _of_tracks(table)
        if names.issuperset(TRUTH_COLUMNS):
            return _of_truth(table, path.with_suffix('.frames'))
    except (OSError, ValueError, TypeError, csv.Error) as error:
        raise RecordError(f'{path}: cannot be read as a table of tracks: {error}') from error
    wanted = ', '.join(TRUTH_COLUMNS)
    raise RecordError(
        f'{path}: expected the CSV of replay, or columns {wanted}; got {sorted(names)}'
    )


def _of_mot(path: Path) -> Record:
    with open_file(path) as file:
        table = np.loadtxt(file, delimiter=',', usecols=range(MOT_COLUMNS), ndmin=2)
    if not np.isfinite(table).all():
        raise ValueError('expected finite numbers')
    rows = empty_rows(len(table))
    rows['frame'], rows['id'] = table[:, 0] - 1, table[:, 1]
    rows['w'], rows['h'] = table[:, 4], table[:, 5]
    rows['u'] = table[:, 2] - 1 + (table[:, 4] - 1) / 2
    rows['v'] = table[:, 3] - 1 + (table[:, 5] - 1) / 2
    return Record.of(rows, _all_frames(rows['frame']))


def _of_tracks(table: Mapping[str, NDArray[np.float64]]) -> Record:
    shown = table['state'] != TENTATIVE
    rows = empty_rows(int(np.count_nonzero(shown)))
    rows['frame'], rows['id'] = table['frame'][shown] - 1, table['track_id'][shown]
    rows['w'], rows['h'] = table['box_w'][shown], table['box_h'][shown]
    for k, (corner, side) in enumerate(zip(CORNER, 'wh', strict=True)):
        if corner in table:  # not in tables of before
            rows['middle'][:, k] = table[corner][shown] + (rows[side] - 1) / 2
    for name in ('stamp', *STATE_COLUMNS):
        rows[name] = table[name][shown]
    rows['coasting'] = table['state'][shown] == COASTING
    for (i, a), (j, b) in itertools.combinations_with_replacement(enumerate(STATE_COLUMNS), 2):
        values = table[f'cov_{a}_{b}'][shown]
        rows['covariance'][:, i, j] = rows['covariance'][:, j, i] = values
    return Record.of(rows, _all_frames(table['frame'] - 1))


def _of_truth(table: Mapping[str, NDArray[np.float64]], frames: Path) -> Record:
    rows = empty_rows(len(table['frame']))
    for name in ('frame', 'id', 'u', 'v', 'w', 'h', 'visible'):
        if name in table:
            rows[name] = table[name]
    if not frames.is_file():
        return Record.of(rows, _all_frames(rows['frame']))
    return Record.of(rows, np.loadtxt(frames, int, ndmin=1).tolist())


def _all_frames(frames: NDArray[np.float64] | NDArray[np.int64]) -> range:
    """All frames from the first to the last one with rows, since a table does not list empty
    ones.
    """
    return range(int(frames.max()) + 1 if len(frames) else 0)
