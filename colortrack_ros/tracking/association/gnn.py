"""Global nearest neighbor: the assignment of greatest total gain (the Hungarian method)."""

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import min_weight_full_bipartite_matching

from colortrack_ros.tracking.association.base import Floats
from colortrack_ros.tracking.association.base import Indices

SMALL = 10_000
"""Entries up to which a dense table is solved rather than a sparse one, which has more overhead.
Measured with three candidates each: at 10,000 they take 106 and 190 us, at 40,000 324 and 270."""


def associate(track: Indices, detection: Indices, gain: Floats) -> tuple[Indices, Floats]:
    """Choose the pairs with the greatest sum of gains; see Associator.

    Pairs worth more than all the alternatives of their track and of their detection together are
    in every best assignment: exchanging them can only lose. Nearly all pairs are, and are taken in
    bulk; what is left is solved as one problem.
    """
    left = (gain > 0).nonzero()[0]
    chosen = []
    while len(left):
        t, d, g = track[left], detection[left], gain[left]
        sure = 3 * g > np.bincount(t, g)[t] + np.bincount(d, g)[d]
        count = np.count_nonzero(sure)
        if not count:
            chosen.append(left[_solve(t, d, g)])
            break
        if count == len(left):
            chosen.append(left)
            break
        chosen.append(left[sure])
        gone_t, gone_d = np.zeros(t.max() + 1, bool), np.zeros(d.max() + 1, bool)
        gone_t[t[sure]] = gone_d[d[sure]] = True
        left = left[~(gone_t[t] | gone_d[d])]
    if len(chosen) == 1:
        return chosen[0], np.ones(len(chosen[0]))
    pairs = np.sort(np.concatenate([left[:0], *chosen]))
    return pairs, np.ones(len(pairs))


def _solve(track: Indices, detection: Indices, gain: Floats) -> Indices:
    """The best assignment by the method of Jonker and Volgenant 1987, on a table or sparse costs.

    In a sparse one each track has a column of its own for a miss, so that every row is matched.
    """
    tracks, row = np.unique(track, return_inverse=True)
    detections, column = np.unique(detection, return_inverse=True)
    n, m = len(tracks), len(detections)
    if n * m <= SMALL:
        dense, pair = np.zeros((n, m)), np.full((n, m), -1)
        dense[row, column], pair[row, column] = gain, np.arange(len(gain))
        chosen = pair[linear_sum_assignment(dense, maximize=True)]
        return chosen[chosen >= 0]
    most = gain.max() + 1
    cost = np.append(most - gain, np.full(n, most))
    rows, columns = np.append(row, np.arange(n)), np.append(column, m + np.arange(n))
    table = csr_matrix((cost, (rows, columns)), shape=(n, m + n))
    _, matched = min_weight_full_bipartite_matching(table)
    return np.flatnonzero(matched[row] == column)
