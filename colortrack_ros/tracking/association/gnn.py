"""Global nearest neighbor: the assignment with the largest total gain (the Hungarian method)."""

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import min_weight_full_bipartite_matching

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.track_table import marked

SMALL = 10_000
"""Number of entries up to which a dense table is solved instead of a sparse one, which has more
overhead. In crowds they take 52 and 94 us at 10,000, 94 and 106 at 25,000, 260 and 150 at
60,000."""


def associate(track: Indices, detection: Indices, gain: Floats) -> tuple[Indices, Floats]:
    """Choose the pairs with the largest sum of gains; see Associator.

    A pair that gains more than all alternatives of its track and of its detection together is in
    every optimal assignment, as exchanging it can only lose. Nearly all pairs do, and are taken in
    bulk; the rest is solved as one problem.
    """
    left = (gain > 0).nonzero()[0]
    chosen = []
    while len(left):
        t, d, g = track[left], detection[left], gain[left]
        sure = 3.0 * g > np.bincount(t, g)[t] + np.bincount(d, g)[d]
        count = np.count_nonzero(sure)
        if not count:
            chosen.append(left[_solve(t, d, g)])
            break
        if count == len(left):
            chosen.append(left)
            break
        chosen.append(left[sure])
        gone_t, gone_d = marked(t[sure], t.max() + 1), marked(d[sure], d.max() + 1)
        left = left[~(gone_t[t] | gone_d[d])]
    if len(chosen) == 1:
        return chosen[0], np.ones(len(chosen[0]))
    pairs = np.sort(np.concatenate([left[:0], *chosen]))
    return pairs, np.ones(len(pairs))


def _solve(track: Indices, detection: Indices, gain: Floats) -> Indices:
    """Return the best assignment by the method of Jonker and Volgenant 1987, dense or sparse.

    In the sparse table each track has a column of its own for a miss, so that every row is matched.
    """
    row, n = _numbered(track)
    column, m = _numbered(detection)
    if n * m <= SMALL:
        dense, pair = np.zeros((n, m)), np.full((n, m), -1)
        dense[row, column], pair[row, column] = gain, np.arange(len(gain))
        chosen = pair[linear_sum_assignment(dense, maximize=True)]
        return chosen[chosen >= 0]
    most = gain.max() + 1
    order = (row * m + column).argsort()
    end = (np.bincount(row) + 1).cumsum()
    place = np.arange(len(row)) + row  # each earlier row has one more entry, for a miss
    cost, columns = np.full(end[-1], most), np.empty(end[-1], np.int32)
    cost[place] = most - gain[order]
    columns[place], columns[end - 1] = column[order], m + np.arange(n)
    table = csr_matrix((cost, columns, np.append(0, end)), shape=(n, m + n))
    _, matched = min_weight_full_bipartite_matching(table)
    return np.flatnonzero(matched[row] == column)


def _numbered(names: Indices) -> tuple[Indices, int]:
    """Number the distinct names from 0, in order; return the numbers, (K,), and their count."""
    number = marked(names, names.max() + 1).cumsum()
    return number[names] - 1, int(number[-1])
