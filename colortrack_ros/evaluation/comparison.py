"""Tracks against the truth."""

from collections import Counter
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
from typing import Any
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.ellipses import ELLIPSE_95
from colortrack_ros.evaluation.correspondence import Score
from colortrack_ros.evaluation.correspondence import Takeover
from colortrack_ros.evaluation.correspondence import Tally
from colortrack_ros.evaluation.hota import Hota
from colortrack_ros.evaluation.hota import HotaTally
from colortrack_ros.evaluation.record import Record

VISIBLE = 0.3
"""Least visible share of an object that has to be found. Assumed; ``evaluate --visible`` sets
another."""


class Event(NamedTuple):
    """An ID switch, or another event that a report points to.

    :param frame: from 0.
    :param object: its ID.
    :param before, after: IDs of its tracks.
    :param u, v: position [px].
    """

    frame: int
    object: int
    before: int
    after: int
    u: float
    v: float


class FalseTrack(NamedTuple):
    """A track that matches no object in most of its frames.

    :param frame: the first without a match.
    :param track: its ID.
    :param frames: number of frames without a match.
    :param u, v: position in the first of them [px].
    """

    frame: int
    track: int
    frames: int
    u: float
    v: float


class Comparison(NamedTuple):
    """The result.

    :param measures: by name, for tables and thresholds.
    :param objects: the measures of each object, by ID.
    :param matches: (K, 3) frame, object and track of each match.
    :param switches: times and places of ID switches.
    :param false_tracks: with their places, in order of appearance.
    :param counts: (F, 4) for each frame evaluated: its number, objects, objects found, and false
        rows.
    """

    measures: dict[str, float]
    objects: dict[int, dict[str, float]]
    matches: Indices
    switches: list[Event]
    false_tracks: list[FalseTrack]
    counts: Indices


def compare(
    truth: Record,
    tracks: Record,
    *,
    radius: float = 0.0,
    iou: float = 0.5,
    visible: float = VISIBLE,
) -> Comparison:
    """Compare the frames that the truth covers.

    :param radius: largest distance of a match's centers [px]; 0: match boxes by their overlap.
    :param iou: least intersection over union of a match.
    :param visible: objects with a smaller visible share need not be found, and tracks on them are
        not false.
    :raises ValueError: boxes are to be matched, and some are unknown.
    """
    limit = _limit(radius, iou, truth, tracks)
    clear, hota, found, spare, counts = Tally(limit), HotaTally(), [], [tracks.rows[:0]], []
    for frame in truth.frames.tolist():
        objects, shown, far = _in_sight(
            truth.rows_of(frame), tracks.rows_of(frame), radius, limit, visible
        )
        i, j = np.nonzero(far <= limit)
        i, j = clear.add_pairs(objects['id'], shown['id'], i, j, far[i, j])
        hota.add(objects['id'], shown['id'], _similarity(far, radius))
        found.append((objects[i], shown[j]))
        spare.append(np.delete(shown, j))
        counts.append((frame, len(objects), len(i), len(spare[-1])))
    right, theirs = map(np.concatenate, zip((truth.rows[:0],) * 2, *found, strict=True))
    judged = np.isin(truth.rows['frame'], truth.frames) & (truth.rows['visible'] >= visible)
    score, frames = clear.score(), Counter(truth.rows['id'][judged].tolist())
    return Comparison(
        measures=_measures(score, hota.score()) | _errors(right, theirs),
        objects=dict(_of_objects(frames, clear.tracks_of, right, theirs)),
        matches=np.stack([right['frame'], right['id'], theirs['id']], axis=1),
        switches=[_event(found[takeover.number][0], takeover) for takeover in clear.takeovers],
        false_tracks=sorted(_false_tracks(np.concatenate(spare), score.false_tracks)),
        counts=np.array(counts, int).reshape(-1, 4),
    )


def _limit(radius: float, iou: float, *records: Record) -> float:
    """Largest distance of a match, in the unit of :func:`_distance`."""
    if not radius and any(np.isnan(record.rows[side]).any() for record in records for side in 'wh'):
        raise ValueError('expected boxes (w, h) in both, or --radius')
    return radius or 1 - iou


def _measures(score: Score, hota: Hota) -> dict[str, float]:
    """By name."""
    names = 'idf1', 'mota', 'precision', 'recall', 'switches', 'fragments', 'misses', 'false'
    values = {name: getattr(score, name) for name in names}
    return hota._asdict() | values | {'false_tracks': len(score.false_tracks)}


def _in_sight(
    objects: NDArray[np.void], shown: NDArray[np.void], radius: float, limit: float, visible: float
) -> tuple[NDArray[np.void], NDArray[np.void], Floats]:
    """The objects to be found, the tracks to be evaluated, and the distances between them."""
    far = _distance(objects, shown, radius)
    hidden = objects['visible'] < visible
    # A track nearest to a hidden object counts neither as right nor as wrong.
    on_hidden = _on_hidden(far, hidden, limit)
    return objects[~hidden], shown[~on_hidden], far[np.ix_(~hidden, ~on_hidden)]


def _false_tracks(spare: NDArray[np.void], names: Sequence[int]) -> Iterator[FalseTrack]:
    """Their places, from the rows without a match in each frame."""
    for name in names:
        rows = spare[spare['id'] == name]
        first = rows[0]
        yield FalseTrack(int(first['frame']), name, len(rows), float(first['u']), float(first['v']))


def _distance(objects: NDArray[np.void], shown: NDArray[np.void], radius: float) -> Floats:
    """(N, M) distances between centers [px], or 1 minus the intersection over union of boxes."""
    a, b = objects[:, None], shown[None, :]
    if radius:
        return np.hypot(a['u'] - b['u'], a['v'] - b['v'])
    both = np.ones((len(objects), len(shown)))
    for k, size in enumerate('wh'):
        mine, theirs = _middle(a, k), _middle(b, k)
        low = np.maximum(mine - a[size] / 2, theirs - b[size] / 2)
        high = np.minimum(mine + a[size] / 2, theirs + b[size] / 2)
        both = both * np.maximum(high - low, 0)
    return 1 - both / np.maximum(a['w'] * a['h'] + b['w'] * b['h'] - both, np.finfo(float).tiny)


def _middle(rows: NDArray[np.void], axis: int) -> Floats:
    """The middles of their boxes along u or v, rows of any shape [px]."""
    middle = rows['middle'][..., axis]
    return np.where(np.isnan(middle), rows['uv'[axis]], middle)


def _similarity(far: Floats, radius: float) -> Floats:
    """Similarity for HOTA, 0..1."""
    return np.maximum(1 - far / radius, 0) if radius else 1 - far


def _on_hidden(far: Floats, hidden: Bools, limit: float) -> Bools:
    """Mask of the tracks whose nearest object need not be found."""
    if not hidden.any() or not far.shape[1]:
        return np.zeros(far.shape[1], bool)
    nearest = far.argmin(axis=0)
    return hidden[nearest] & (far.min(axis=0) <= limit)


def _event(found: NDArray[np.void], takeover: Takeover) -> Event:
    """The place of a switch, among the objects found in that frame."""
    (row,) = found[found['id'] == takeover.object]
    return Event(int(row['frame']), *takeover[1:], float(row['u']), float(row['v']))


def _errors(right: NDArray[np.void], theirs: NDArray[np.void]) -> dict[str, float]:
    """Errors of the matched positions, and whether the covariances account for them."""
    e = np.stack([theirs['u'] - right['u'], theirs['v'] - right['v']], axis=1)
    measures = {'rmse': _root_mean_square(e)}
    every = np.ones(len(theirs), bool)
    for name, rows in (('', every), ('coasting_', theirs['coasting'])):
        P = theirs['covariance'][rows, :2, :2]
        known = np.isfinite(P).all(axis=(1, 2)) & (np.linalg.det(np.nan_to_num(P)) > 0)
        if not known.any():
            continue
        d = e[rows][known]
        nees = np.einsum('ki,ki->k', d, np.linalg.solve(P[known], d[..., None])[..., 0])
        measures[f'{name}nees'] = float(nees.mean()) / 2
        measures[f'{name}coverage'] = float((nees <= ELLIPSE_95).mean())
    return measures


def _root_mean_square(e: Floats) -> float:
    return float(np.sqrt((e**2).sum(axis=1).mean())) if len(e) else float('nan')


def _of_objects(
    frames: Mapping[int, int],
    tracks_of: Mapping[int, list[int]],
    right: NDArray[np.void],
    theirs: NDArray[np.void],
) -> Iterator[tuple[int, dict[str, Any]]]:
    """The measures of each object.

    :param frames: number of frames in which it should be found.
    """
    for one, count in sorted(frames.items()):
        mine = right['id'] == one
        e = np.stack([theirs[name][mine] - right[name][mine] for name in ('u', 'v')], axis=1)
        history = tracks_of.get(one, [])
        yield (
            one,
            {
                'frames': count,
                'found': len(e) / count,
                'switches': max(len(history) - 1, 0),
                'rmse': _root_mean_square(e),
                'tracks': history,
            },
        )
