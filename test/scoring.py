"""How well tracks follow the truth: CLEAR MOT and identity measures, in arrays.

The definitions are those of motmetrics (a test compares): correspondences of the last frame are
kept while they are within the distance (Bernardin and Stiefelhagen 2008), the rest are assigned
anew; identities are matched once over the whole sequence (Ristani et al. 2016).
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist


@dataclass(frozen=True)
class Score:
    """What came out.

    switches: times an object was taken over by another track; idf1: 0..1; mota: up to 1;
    rmse: of the matched positions [px]; misses: objects unmatched, over all frames; false: track
    rows unmatched, over all frames; false_tracks: IDs of tracks unmatched in most of their frames;
    tracks_of: for each object the IDs it had, in order.
    """

    switches: int
    idf1: float
    mota: float
    rmse: float
    misses: int
    false: int
    false_tracks: list[int]
    tracks_of: dict[int, list[int]]


def score(truth: Iterable, tracks: Iterable, max_distance: float) -> Score:
    """Compare, frame by frame.

    :param truth: for each frame rows of (object, u, v).
    :param tracks: for each frame rows of (track_id, u, v).
    :param max_distance: of a match [px].
    """
    tally = Tally(max_distance)
    for objects, hypotheses in zip(truth, tracks, strict=True):
        tally.add(objects, hypotheses)
    return tally.score()


class Tally:
    """The same, a frame at a time.

    :param max_distance: of a match [px].
    """

    def __init__(self, max_distance: float) -> None:
        self.max_distance = max_distance
        self.switches = self.misses = self.false = 0
        self.squares: list[np.ndarray] = []
        self.tracks_of: dict[int, list[int]] = {}
        self.together: list[np.ndarray] = []
        self.matched: list[np.ndarray] = []
        self.seen: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])

    def add(self, objects: object, hypotheses: object, hidden: int = 0) -> None:
        """Take one frame.

        :param objects: rows of (object, u, v).
        :param hypotheses: rows of (track_id, u, v).
        :param hidden: objects that are there but cannot be seen, besides the others: so many tracks
            that are near none of these are forgiven, the farthest first.
        """
        truth = np.asarray(objects, float).reshape(-1, 3)
        tracks = np.asarray(hypotheses, float).reshape(-1, 3)
        distance = cdist(truth[:, 1:], tracks[:, 1:])
        nearest = distance.min(axis=0, initial=np.inf)
        order = np.argsort(-nearest, kind='stable')
        order = order[max(0, min(hidden, np.count_nonzero(nearest > self.max_distance))) :]
        tracks, distance = tracks[order], distance[:, order]
        ids, names = truth[:, 0].astype(int), tracks[:, 0].astype(int)
        self.seen[0].append(ids)
        self.seen[1].append(names)
        near = distance <= self.max_distance
        i, j = np.nonzero(near)
        self.together.append(np.stack([ids[i], names[j]], axis=1))
        i, j = self._match(ids, names, distance, near)
        self.squares.append(distance[i, j] ** 2)
        self.misses += len(ids) - len(i)
        self.false += len(names) - len(i)
        self.matched.append(names[j])
        for one, name in zip(ids[i].tolist(), names[j].tolist(), strict=True):
            history = self.tracks_of.setdefault(one, [])
            if not history or history[-1] != name:
                self.switches += bool(history)
                history.append(name)

    def _match(self, ids, names, distance, near):
        column = {name: j for j, name in enumerate(names.tolist())}
        last = [self.tracks_of.get(one, [-1])[-1] for one in ids.tolist()]
        old = np.array([column.get(name, -1) for name in last], int)
        kept = np.flatnonzero(old >= 0)
        kept = kept[near[kept, old[kept]]]
        kept = kept[np.unique(old[kept], return_index=True)[1]]
        cost = np.where(near, distance, 1e9)
        cost[kept, :] = cost[:, old[kept]] = 1e9
        i, j = linear_sum_assignment(cost)
        new = cost[i, j] < 1e9
        return np.concatenate([kept, i[new]]), np.concatenate([old[kept], j[new]])

    def score(self) -> Score:
        """Sum up."""
        squares = np.concatenate([*self.squares, []])
        ids, truth_count = np.unique(np.concatenate([*self.seen[0], []]), return_counts=True)
        names, track_count = np.unique(np.concatenate([*self.seen[1], []]), return_counts=True)
        total, rows = truth_count.sum(), track_count.sum()
        pairs = np.concatenate([*self.together, np.zeros((0, 2), int)])
        common = np.zeros((len(ids), len(names)))
        np.add.at(
            common, (np.searchsorted(ids, pairs[:, 0]), np.searchsorted(names, pairs[:, 1])), 1
        )
        true_positives = common[linear_sum_assignment(common, maximize=True)].sum()
        hits = np.bincount(
            np.searchsorted(names, np.concatenate([*self.matched, []])), minlength=len(names)
        )
        return Score(
            switches=self.switches,
            idf1=2 * true_positives / max(total + rows, 1),
            mota=1 - (self.misses + self.false + self.switches) / max(total, 1),
            rmse=float(np.sqrt(squares.mean())) if len(squares) else float('nan'),
            misses=self.misses,
            false=self.false,
            false_tracks=names[2 * hits < track_count].astype(int).tolist(),
            tracks_of=self.tracks_of,
        )
