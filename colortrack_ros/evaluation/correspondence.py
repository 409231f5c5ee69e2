"""CLEAR MOT and identity measures, in arrays.

The definitions are those of motmetrics (a test compares the two): correspondences of the last frame
are kept while they are within the distance, and all others are assigned anew (Bernardin and
Stiefelhagen 2008); identities are matched once over the whole sequence (Ristani et al. 2016).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import min_weight_full_bipartite_matching
from scipy.spatial import cKDTree

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices


class Takeover(NamedTuple):
    """An object is matched to another track than when it was last matched.

    :param number: of the frame, in the order in which frames were added, from 0.
    :param object: its ID.
    :param before, after: IDs of its tracks.
    """

    number: int
    object: int
    before: int
    after: int


@dataclass(frozen=True)
class Score:
    """The result.

    switches: number of times an object was matched to another track than before; fragments: number
    of times an object was found again after it had been lost; idf1, precision, recall: 0..1; mota:
    up to 1; rmse: of the matched positions, in the unit of the distance; misses: unmatched objects,
    over all frames; false: unmatched track rows, over all frames; false_tracks: IDs of tracks that
    are unmatched in most of their frames; tracks_of: the IDs that each object had, in order.
    """

    switches: int
    fragments: int
    idf1: float
    mota: float
    precision: float
    recall: float
    rmse: float
    misses: int
    false: int
    false_tracks: list[int]
    tracks_of: dict[int, list[int]]


def score(truth: Iterable, tracks: Iterable, max_distance: float) -> Score:
    """Compare tracks with the truth, frame by frame.

    :param truth: for each frame rows of (object, u, v).
    :param tracks: for each frame rows of (track_id, u, v).
    :param max_distance: of a match [px].
    """
    tally = Tally(max_distance)
    for objects, hypotheses in zip(truth, tracks, strict=True):
        tally.add(objects, hypotheses)
    return tally.score()


class Tally:
    """The same comparison, one frame at a time.

    :param max_distance: of a match [px].
    :ivar takeovers: so far, in order.
    :ivar tracks_of: for each object the IDs it had, in order.
    """

    def __init__(self, max_distance: float) -> None:
        self.max_distance = max_distance
        self.misses = self.false = self.fragments = 0
        self.takeovers: list[Takeover] = []
        self.squares: list[Floats] = []
        self.tracks_of: dict[int, list[int]] = {}
        self.together: list[Indices] = []
        self.matched: list[Indices] = []
        self.seen: tuple[list[Indices], list[Indices]] = ([], [])
        self._lost: dict[int, bool] = {}

    def add(self, objects: ArrayLike, hypotheses: ArrayLike, hidden: int = 0) -> None:
        """Take one frame.

        :param objects: rows of (object, u, v).
        :param hypotheses: rows of (track_id, u, v).
        :param hidden: number of objects that are present but cannot be seen, not counting
            ``objects``; as many unmatched tracks do not count as false, the farthest first.
        """
        truth = np.asarray(objects, float).reshape(-1, 3)
        tracks = np.asarray(hypotheses, float).reshape(-1, 3)
        objects_at = cKDTree(truth[:, 1:])
        if hidden and len(tracks):
            nearest = objects_at.query(tracks[:, 1:])[0]
            order = np.argsort(-nearest, kind='stable')
            far = np.count_nonzero(nearest > self.max_distance)
            tracks = tracks[order[min(hidden, far) :]]
        near = objects_at.query_ball_point(tracks[:, 1:], self.max_distance)
        i = np.concatenate([*near, []]).astype(int)
        j = np.repeat(np.arange(len(tracks)), [len(some) for some in near])
        distance = np.hypot(*(truth[i, 1:] - tracks[j, 1:]).T)
        self.add_pairs(truth[:, 0].astype(int), tracks[:, 0].astype(int), i, j, distance)

    def add_pairs(
        self, ids: Indices, names: Indices, i: Indices, j: Indices, distance: Floats
    ) -> tuple[Indices, Indices]:
        """Take one frame whose candidate pairs are known.

        :param ids, names: objects (N,) and tracks (M,).
        :param i, j: (K,) indices of the pairs that may correspond.
        :param distance: (K,) their distances.
        :return: indices into ids and into names of the pairs chosen.
        """
        self.seen[0].append(ids)
        self.seen[1].append(names)
        self.together.append(np.stack([ids[i], names[j]], axis=1))
        matched = self._match(ids[i], names[j], i, j, distance)
        i, j = i[matched], j[matched]
        self.squares.append(distance[matched] ** 2)
        self.misses += len(ids) - len(i)
        self.false += len(names) - len(i)
        self.matched.append(names[j])
        for one, name in zip(ids[i].tolist(), names[j].tolist(), strict=True):
            history = self.tracks_of.setdefault(one, [])
            if not history or history[-1] != name:
                if history:
                    self.takeovers.append(Takeover(len(self.seen[0]) - 1, one, history[-1], name))
                history.append(name)
        found = set(ids[i].tolist())
        for one in ids.tolist():
            self.fragments += one in found and self._lost.get(one, False)
            if one in found or one in self._lost:
                self._lost[one] = one not in found
        return i, j

    def _match(
        self, ids: Indices, names: Indices, i: Indices, j: Indices, distance: Floats
    ) -> Indices:
        """Indices of the K candidate pairs that correspond: those that did before, then the
        nearest.
        """
        # mostly nobody has a choice
        if np.bincount(i).max(initial=0) <= 1 and np.bincount(j).max(initial=0) <= 1:
            return np.arange(len(i))
        last = np.array([self.tracks_of.get(one, [-1])[-1] for one in ids.tolist()])
        kept = np.flatnonzero(last == names)
        kept = kept[np.unique(j[kept], return_index=True)[1]]
        rest = np.flatnonzero(~np.isin(i, i[kept]) & ~np.isin(j, j[kept]))
        return np.append(kept, rest[best_pairs(i[rest], j[rest], distance[rest])])

    def score(self) -> Score:
        """Return the result over all frames so far."""
        squares = np.concatenate([*self.squares, []])
        names, track_count = np.unique(np.concatenate([*self.seen[1], []]), return_counts=True)
        total, rows = sum(map(len, self.seen[0])), int(track_count.sum())
        pairs = np.concatenate([*self.together, np.zeros((0, 2), int)])
        pairs, common = np.unique(pairs, axis=0, return_counts=True)
        true_positives = common[best_pairs(pairs[:, 0], pairs[:, 1], -common, miss=0.0)].sum()
        hits = np.bincount(
            np.searchsorted(names, np.concatenate([*self.matched, []])), minlength=len(names)
        )
        return Score(
            switches=len(self.takeovers),
            fragments=self.fragments,
            idf1=float(2 * true_positives / max(total + rows, 1)),
            mota=1 - (self.misses + self.false + len(self.takeovers)) / max(total, 1),
            precision=(rows - self.false) / max(rows, 1),
            recall=(total - self.misses) / max(total, 1),
            rmse=float(np.sqrt(squares.mean())) if len(squares) else float('nan'),
            misses=self.misses,
            false=self.false,
            false_tracks=names[2 * hits < track_count].astype(int).tolist(),
            tracks_of=self.tracks_of,
        )


def best_pairs(one: Indices, other: Indices, cost: ArrayLike, miss: float = 1e9) -> Indices:
    """Choose pairs with the least total cost; each name is in at most one of them.

    :param one, other: (K,) names.
    :param cost: (K,) of the pairs.
    :param miss: cost of a name in ``one`` without a pair.
    :return: indices of the pairs chosen.
    """
    cost = np.asarray(cost, float)
    if not len(cost):
        return np.zeros(0, int)
    rows, row = np.unique(one, return_inverse=True)
    columns, column = np.unique(other, return_inverse=True)
    n, m = len(rows), len(columns)
    shift = 1 - min(cost.min(), miss)  # in a sparse matrix a cost of 0 would be no pair
    table = csr_matrix(
        (
            np.append(cost, np.full(n, miss)) + shift,
            (np.append(row, np.arange(n)), np.append(column, m + np.arange(n))),
        ),
        shape=(n, m + n),
    )
    _, matched = min_weight_full_bipartite_matching(table)
    return np.flatnonzero(matched[row] == column)
