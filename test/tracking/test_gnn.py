from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
from scipy.optimize import linear_sum_assignment

from colortrack_ros.tracking.association.gnn import associate


@given(
    seed=st.integers(0, 2**32 - 1),
    shape=st.tuples(st.integers(1, 40), st.integers(1, 40)),
    density=st.floats(0.01, 1.0),
    levels=st.sampled_from([3, 50, None]),
)
@settings(max_examples=300, deadline=None)
def test_the_total_is_that_of_the_dense_assignment(seed, shape, density, levels):
    """With few levels there are many ties."""
    rng = np.random.default_rng(seed)
    table = np.where(rng.random(shape) < density, rng.exponential(5, shape), 0)
    if levels:
        table = np.ceil(table * levels / 20)
    track, detection = np.nonzero(table)
    gain = table[track, detection]
    chosen, _ = associate(track, detection, gain)
    assert len(set(track[chosen])) == len(set(detection[chosen])) == len(chosen)
    assert (np.diff(chosen) > 0).all()
    best = table[linear_sum_assignment(table, maximize=True)].sum()
    np.testing.assert_allclose(gain[chosen].sum(), best, rtol=1e-12)
