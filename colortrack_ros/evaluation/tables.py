"""Reads tracks and truth from text: CSV written by replay, MOTChallenge, CSV of truth."""

from collections.abc import Mapping
from collections.abc import Sequence
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

STATE_COLUMNS = ('u', 'v', 'du', 'dv')
COVARIANCES = tuple(itertools.combinations_with_replacement(enumerate(STATE_COLUMNS), 2))
"""Number and name of both columns, for each covariance of a track."""

TRUTH_COLUMNS, MORE_OF_TRUTH = ('frame', 'id', 'u', 'v'), ('w', 'h', 'visible')
TRACK_COLUMNS = (
    'frame', 'track_id', 'state', *STATE_COLUMNS, 'box_w', 'box_h', 'stamp',
    *(f'cov_{a}_{b}' for (_, a), (_, b) in COVARIANCES),
)  # fmt: skip

MOT_COLUMNS = 6
"""frame, id, left, top, width, height; further columns of tracks are ignored."""

MOT_TRUTH_COLUMNS, IS_COUNTED = 9, 6
"""Columns of a truth of MOTChallenge, and the one that is 0 where an object does not count, such as
a car (Milan et al. 2016, MOT16). Tracks have 10 columns."""

FRAMES_AT_MOST = 10_000_000
"""Largest number of a frame: four days at 30 Hz. A larger one is a time."""


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
        with open_file(path) as file, io.TextIOWrapper(file, 'utf-8-sig', newline='') as text:
            if path.suffix.lower() == '.txt':
                return _of_mot(text.read())
            lines = csv.DictReader(text, skipinitialspace=True)
            names = lines.fieldnames or ()
            if set(names).issuperset(TRACK_COLUMNS):
                return _of_tracks(_table(lines, (*TRACK_COLUMNS, *CORNER)))
            if set(names).issuperset(TRUTH_COLUMNS):
                table = _table(lines, (*TRUTH_COLUMNS, *MORE_OF_TRUTH))
                return _of_truth(table, path.with_suffix('.frames'))
    except (OSError, ValueError, csv.Error) as error:
        raise RecordError(f'{path}: cannot be read as a table of tracks: {error}') from error
    wanted = ', '.join(TRUTH_COLUMNS)
    raise RecordError(
        f'{path}: expected the CSV of replay, or columns {wanted}, with commas between; '
        f'got {sorted(names)}'
    )


def _table(
    lines: 'csv.DictReader[str]', wanted: Sequence[str]
) -> Mapping[str, NDArray[np.float64]]:
    """The wanted columns, as far as they are there.

    :raises ValueError: a column is there twice, or a value is not a number.
    """
    names = list(lines.fieldnames or ())
    columns: Mapping[str, list[float]] = {name: [] for name in wanted if name in names}
    if twice := [name for name in columns if names.count(name) > 1]:
        raise ValueError(f'expected each column once, got {twice[0]} {names.count(twice[0])} times')
    for line in lines:
        for name, values in columns.items():
            try:
                # a double would round a time since 1970 to 256 ns
                exact = name == 'stamp' and str(line[name]).isdecimal()
                values.append(int(line[name]) if exact else float(line[name]))
            except (TypeError, ValueError):
                told = f'expected a number for {name}, got {line[name]!r}'
                raise ValueError(f'line {lines.line_num}: {told}') from None
    return {name: np.array(values) for name, values in columns.items()}


def _of_mot(text: str) -> Record:
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith('#')]
    is_truth = bool(lines) and len(lines[0].split(',')) == MOT_TRUTH_COLUMNS
    columns = range(IS_COUNTED + 1 if is_truth else MOT_COLUMNS)
    if lines:
        table = np.loadtxt(lines, delimiter=',', usecols=columns, ndmin=2)
    else:
        table = np.zeros((0, len(columns)))
    _require_finite(table)
    rows = _numbered(table[:, 0], table[:, 1], 1)
    rows['w'], rows['h'] = table[:, 4], table[:, 5]
    rows['u'] = table[:, 2] - 1 + (table[:, 4] - 1) / 2
    rows['v'] = table[:, 3] - 1 + (table[:, 5] - 1) / 2
    if is_truth:
        rows['visible'] = table[:, IS_COUNTED] != 0
    return Record.of(rows, _all_frames(rows['frame']))


def _of_tracks(table: Mapping[str, NDArray[np.float64]]) -> Record:
    shown = table['state'] != TENTATIVE
    rows = _numbered(table['frame'], table['track_id'], 1)
    frames = _all_frames(rows['frame'])
    rows = rows[shown]
    rows['w'], rows['h'] = table['box_w'][shown], table['box_h'][shown]
    for k, (corner, side) in enumerate(zip(CORNER, 'wh', strict=True)):
        if corner in table:  # not in tables of before
            rows['middle'][:, k] = table[corner][shown] + (rows[side] - 1) / 2
    for name in ('stamp', *STATE_COLUMNS):
        _require_finite(table[name])
        rows[name] = table[name][shown]
    rows['coasting'] = table['state'][shown] == COASTING
    for (i, a), (j, b) in COVARIANCES:
        values = table[f'cov_{a}_{b}'][shown]
        rows['covariance'][:, i, j] = rows['covariance'][:, j, i] = values
    return Record.of(rows, frames)


def _of_truth(table: Mapping[str, NDArray[np.float64]], frames: Path) -> Record:
    rows = _numbered(table['frame'], table['id'], 0)
    for name in ('u', 'v', 'w', 'h', 'visible'):
        if name in table:
            _require_finite(table[name])
            rows[name] = table[name]
    if not frames.is_file():
        return Record.of(rows, _all_frames(rows['frame']))
    return Record.of(rows, np.loadtxt(frames, int, ndmin=1).tolist())


def _numbered(
    frames: NDArray[np.float64], ids: NDArray[np.float64], first: int
) -> NDArray[np.void]:
    """Empty rows with frames and IDs.

    :param first: the number of the first frame of a recording.
    :raises ValueError: they are not whole numbers, or frames are out of range.
    """
    for name, values in (('frames', frames), ('IDs', ids)):
        if (wrong := values[~(values == np.round(values)) | (np.abs(values) >= 2**53)]).size:
            raise ValueError(f'expected whole numbers for {name}, got {wrong[0]:.16g}')
    if (wrong := frames[(frames < first) | (frames > FRAMES_AT_MOST)]).size:
        told = f'expected frames from {first} to {FRAMES_AT_MOST}, got {wrong[0]:.0f}'
        raise ValueError(told)
    rows = empty_rows(len(frames))
    rows['frame'], rows['id'] = frames - first, ids
    return rows


def _require_finite(values: NDArray[np.float64]) -> None:
    if not np.isfinite(values).all():
        raise ValueError('expected finite numbers')


def _all_frames(frames: NDArray[np.int64]) -> range:
    """All frames from the first to the last one with rows, since a table does not list empty
    ones.
    """
    return range(int(frames.max()) + 1 if len(frames) else 0)
