"""Ground truth from clicks: marks in some frames, and labels for the frames between them."""

from collections.abc import Sequence
from dataclasses import dataclass
import io
import itertools

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.evaluation import Record
from colortrack_ros.tuner.survey import SIGHTING

NO_SIZE = 20.0
"""Side of a box of unknown size [px]. Assumed: large enough to be seen and corrected."""

MARGIN = 6.0
"""How far outside a box a click still selects it [px]. Assumed: how far people miss on a screen."""

NONE, MEASURED, GUESSED = 0, 1, 2
"""States of an object in a frame: no label; marked or measured; between such frames."""


@dataclass(frozen=True)
class Mark:
    """A mark of an object in a frame.

    :param box: u, v of its center, width and height [px], size 0 for a click; None if it is gone.
    :param track: the selected track; None for the one at this place.
    """

    box: tuple[float, float, float, float] | None
    track: int | None = None


@dataclass(frozen=True)
class Labels:
    """The labels of an object.

    :param state: (F,) NONE, MEASURED or GUESSED.
    :param box: (F, 4) u, v of its center, width and height [px].
    :param visible: (F,) visible share, 0 where it is guessed.
    """

    state: NDArray[np.int8]
    box: NDArray[np.float64]
    visible: NDArray[np.float64]


def propose(marks: dict[int, Mark], frames: Sequence[NDArray[np.void]]) -> Labels:
    """The labels of an object in every frame.

    From a mark, the selected track is followed in both directions until another mark takes over. If
    both tracks exist there, the change is at the frame in which they are nearest to each other,
    where they have swapped. Gaps are interpolated, but not across a mark that the object is gone.

    :param marks: by frame.
    :param frames: sightings of the tracker in each frame, of dtype SIGHTING.
    """
    count = max(len(frames), max(marks, default=-1) + 1)
    box = np.full((count, 5), np.nan)  # and the visible share
    order = sorted(marks)
    tracks = {k: _track_at(marks[k], frames[k] if k < len(frames) else None) for k in order}
    for before, after in zip([None, *order], [*order, None], strict=True):
        _fill(box, before, after, tracks, frames)
    for k in order:
        _put_mark(box, k, marks[k], frames[k] if k < len(frames) else None)
    known = np.isfinite(box[:, 0])
    state = np.where(known, np.where(box[:, 4] > 0, MEASURED, GUESSED), NONE).astype(np.int8)
    ends = [-1, *(k for k in order if marks[k].box is None), count]
    for begin, end in itertools.pairwise(ends):
        _interpolate(box, state, begin + 1, end)
    _give_sizes(box, state)
    return Labels(state, box[:, :4], np.nan_to_num(box[:, 4]))


def _track_at(mark: Mark, seen: NDArray[np.void] | None) -> int | None:
    """The track that a mark selects; None if it selects none."""
    k = _nearest(mark, seen)
    return None if k is None or seen is None else int(seen['track'][k])


def _nearest(mark: Mark, seen: NDArray[np.void] | None) -> int | None:
    if mark.box is None or seen is None or not len(seen):
        return None
    if mark.track is not None:
        return int((seen['track'] == mark.track).argmax())
    away = np.abs(seen['box'][:, :2] - mark.box[:2])
    inside = (away <= seen['box'][:, 2:] / 2 + MARGIN).all(axis=1)
    distance = np.where(inside, np.hypot(*away.T), np.inf)
    k = int(distance.argmin())
    return k if inside[k] else None


def _path(track: int | None, begin: int, end: int, frames: Sequence[NDArray[np.void]]) -> NDArray:
    """(end - begin, 5) boxes and visible shares of a track where it was measured; NaN elsewhere."""
    path = np.full((max(end - begin, 0), 5), np.nan)
    for k in range(begin, min(end, len(frames))):
        (mine,) = ((frames[k]['track'] == track) & frames[k]['measured']).nonzero()
        if len(mine):
            path[k - begin] = [*frames[k]['box'][mine[0]], frames[k]['visible'][mine[0]]]
    return path


def _fill(
    box: NDArray[np.float64],
    before: int | None,
    after: int | None,
    tracks: dict[int, int | None],
    frames: Sequence[NDArray[np.void]],
) -> None:
    """Boxes from one mark to the next; None for the ends of the recording."""
    begin, end = 0 if before is None else before, len(box) if after is None else after
    first = _path(None if before is None else tracks[before], begin, end, frames)
    second = _path(None if after is None else tracks[after], begin, end, frames)
    both = np.isfinite(first[:, 0]) & np.isfinite(second[:, 0])
    if both.any():
        away = np.where(both, np.hypot(*(first - second)[:, :2].T), np.inf)
        change = int(away.argmin())
    else:
        (alive,) = np.isfinite(first[:, 0]).nonzero()
        change = int(alive[-1]) + 1 if len(alive) else 0
    box[begin : begin + change] = first[:change]
    box[begin + change : end] = second[change:]


def _put_mark(box: NDArray[np.float64], k: int, mark: Mark, seen: NDArray[np.void] | None) -> None:
    """A mark overrides its frame: a box as drawn, a click on a blob as that blob."""
    near = _nearest(mark, seen)
    if mark.box is None:
        box[k] = np.nan
    elif mark.box[2] > 0 or near is None or seen is None:
        box[k] = [*mark.box[:2], *(size or np.nan for size in mark.box[2:]), 1.0]
    else:
        box[k] = [*seen['box'][near], seen['visible'][near] if mark.track is not None else 1.0]


def _interpolate(box: NDArray[np.float64], state: NDArray[np.int8], begin: int, end: int) -> None:
    """Interpolate between the known frames of a stretch."""
    (known,) = (state[begin:end] != NONE).nonzero()
    if len(known) < 2:
        return
    span = np.arange(known[0], known[-1] + 1)
    missing = begin + span[state[begin + span] == NONE]
    for column in box.T[:2]:
        column[missing] = np.interp(missing, begin + known, column[begin + known])
    state[missing] = GUESSED


def _give_sizes(box: NDArray[np.float64], state: NDArray[np.int8]) -> None:
    """Fill in unknown sizes from the nearest frames."""
    (labeled,) = (state != NONE).nonzero()
    for column in box.T[2:4]:
        (sized,) = (np.isfinite(column) & (state != NONE)).nonzero()
        given = column[sized] if len(sized) else [NO_SIZE]
        at = sized if len(sized) else [0]
        column[labeled] = np.interp(labeled, at, given)


def csv_of(labels: dict[int, Labels]) -> str:
    """CSV: frame (from 0), id, u, v, w, h, visible (0 if neither marked nor measured)."""
    lines = io.StringIO()
    lines.write('frame,id,u,v,w,h,visible\n')
    for frame, name, (u, v, width, height), visible in _rows(labels):
        lines.write(f'{frame},{name},{u:.2f},{v:.2f},{width:.2f},{height:.2f},{visible:.3g}\n')
    return lines.getvalue()


def mot_of(labels: dict[int, Labels]) -> str:
    """MOTChallenge: frame, id, left, top, width, height, 1, -1, -1, visible; all count from 1."""
    lines = io.StringIO()
    for frame, name, (u, v, width, height), visible in _rows(labels):
        left, top = u - (width - 1) / 2 + 1, v - (height - 1) / 2 + 1
        lines.write(
            f'{frame + 1},{name},{left:.2f},{top:.2f},{width:.2f},{height:.2f},1,-1,{visible:.3g}\n'
        )
    return lines.getvalue()


def _rows(labels: dict[int, Labels]) -> list[tuple[int, int, list[float], float]]:
    """Frame, id, box and visible share of all labels, in the order of the frames."""
    return sorted(
        (k, name, found.box[k].tolist(), float(found.visible[k]))
        for name, found in labels.items()
        for k in found.state.nonzero()[0].tolist()
    )


def sightings_of(truth: Record) -> list[NDArray[np.void]]:
    """A truth in the form of a survey, with its IDs: (N,) of dtype SIGHTING for each frame."""
    frames = []
    for frame in range(int(truth.rows['frame'].max(initial=-1)) + 1):
        rows = truth.rows_of(frame)
        seen = np.zeros(len(rows), SIGHTING)
        box = np.stack([rows[name] for name in ('u', 'v', 'w', 'h')], axis=1)
        seen['track'], seen['visible'], seen['measured'] = rows['id'], rows['visible'], True
        seen['box'] = np.where(np.isfinite(box), box, NO_SIZE)
        frames.append(seen)
    return frames
