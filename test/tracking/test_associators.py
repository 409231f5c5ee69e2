from itertools import product

from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from colortrack_ros.tracking.association import ASSOCIATORS

random_tables = given(
    seed=st.integers(0, 2**32 - 1),
    shape=st.tuples(st.integers(1, 40), st.integers(1, 40)),
    density=st.floats(0.01, 1.0),
    levels=st.sampled_from([3, 50, None]),
)


def table_of(seed, shape, density, levels):
    """Return gains of tracks by detections, 0 for no pair; with few levels many gains are equal."""
    rng = np.random.default_rng(seed)
    table = np.where(rng.random(shape) < density, rng.exponential(5, shape), 0)
    return np.ceil(table * levels / 20) if levels else table


@pytest.mark.slow
@random_tables
@settings(max_examples=300, deadline=None)
def test_gnn_has_the_total_of_the_dense_assignment(seed, shape, density, levels):
    table = table_of(seed, shape, density, levels)
    track, detection = np.nonzero(table)
    gain = table[track, detection]
    chosen, share = ASSOCIATORS['gnn'](track, detection, gain)
    assert len(set(track[chosen])) == len(set(detection[chosen])) == len(chosen)
    assert (np.diff(chosen) > 0).all()
    assert (share == 1).all()
    best = table[linear_sum_assignment(table, maximize=True)].sum()
    np.testing.assert_allclose(gain[chosen].sum(), best, rtol=1e-12)


def test_gnn_has_it_when_much_is_left_to_solve():
    table = table_of(0, (150, 150), 0.1, None)
    track, detection = np.nonzero(table)
    chosen, _ = ASSOCIATORS['gnn'](track, detection, table[track, detection])
    best = table[linear_sum_assignment(table, maximize=True)].sum()
    np.testing.assert_allclose(table[track, detection][chosen].sum(), best, rtol=1e-12)


@random_tables
@settings(max_examples=100, deadline=None)
def test_nearest_gives_each_track_its_own_best_or_none(seed, shape, density, levels):
    table = table_of(seed, shape, density, levels)
    track, detection = np.nonzero(table)
    gain = table[track, detection]
    chosen, _ = ASSOCIATORS['nearest'](track, detection, gain)
    assert len(set(track[chosen])) == len(set(detection[chosen])) == len(chosen)
    for pair in chosen:
        assert gain[pair] == table[track[pair]].max()


def marginals(table):
    """Return the probability of each pair over all joint events.

    A pair has the weight exp(gain), a miss has 1.
    """
    sums, total = np.zeros(table.shape), 0.0
    for event in product(range(-1, table.shape[1]), repeat=table.shape[0]):
        hit = [(i, j) for i, j in enumerate(event) if j >= 0]
        taken = [j for _, j in hit]
        if len(set(taken)) < len(taken) or any(table[i, j] == -np.inf for i, j in hit):
            continue
        weight = np.exp(sum(table[i, j] for i, j in hit))
        total += weight
        for i, j in hit:
            sums[i, j] += weight
    return sums / total


def jpda(table):
    """Return the probabilities of a table of gains, -inf for no pair."""
    track, detection = np.nonzero(table > -np.inf)
    found = np.zeros(table.shape)
    chosen, share = ASSOCIATORS['jpda'](track, detection, table[track, detection])
    found[track[chosen], detection[chosen]] = share
    return found


def test_jpda_has_nearly_the_marginals_of_all_joint_events():
    """Crowds are worse than in any picture: up to four tracks, each near almost all detections."""
    rng = np.random.default_rng(0)
    errors = []
    for _ in range(300):
        table = rng.normal(1, 3, rng.integers(1, 5, 2))
        table[rng.random(table.shape) < 0.3] = -np.inf
        found = jpda(table)
        assert (found.sum(axis=1) <= 1 + 1e-9).all()
        errors.extend(np.abs(found - marginals(table))[table > -np.inf])
    assert np.mean(errors) < 0.02
    assert max(errors) < 0.3


def test_jpda_is_exact_without_cycles():
    """Two tracks compete for one detection; the second has another one, too."""
    table = np.array([[2.0, -np.inf], [1.0, 0.5]])
    np.testing.assert_allclose(jpda(table), marginals(table), atol=1e-3)


@pytest.mark.parametrize('name', ASSOCIATORS)
def test_nothing_in_is_nothing_out(name):
    empty = np.zeros(0, int)
    chosen, share = ASSOCIATORS[name](empty, empty, np.zeros(0))
    assert len(chosen) == len(share) == 0
