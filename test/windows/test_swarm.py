from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows.swarm import Swarm


@settings(deadline=None, max_examples=50)
@given(seed=st.integers(0, 2**31 - 1), targets=st.integers(1, 12), frames=st.integers(1, 8))
def test_the_swarm_comes_near_the_known_minimum(seed, targets, frames):
    rng = np.random.default_rng(seed)
    velocity = rng.uniform(-20, 20, (targets, frames, 2))
    velocity[rng.random((targets, frames)) < 0.3] = np.nan
    velocity[:, 0] = rng.uniform(-20, 20, (targets, 2))
    found = Swarm(WindowConfig(seed=seed)).search(velocity)
    extent = np.hypot(*(np.nanmax(velocity, axis=1) - np.nanmin(velocity, axis=1)).T)
    miss = np.hypot(*(found - np.nanmean(velocity, axis=1)).T)
    assert (miss <= 0.01 * extent + 1e-9).all()


def test_the_same_seed_gives_the_same_search_and_another_another():
    velocity = np.random.default_rng(1).normal(size=(3, 6, 2))
    one, same, other = (Swarm(WindowConfig(seed=s)).search(velocity) for s in (7, 7, 8))
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()


def test_particles_take_no_longer_steps_than_v_max():
    velocity = np.array([[[0.0, 0.0], [100.0, 100.0]]])
    way = []
    for seed in range(10):
        config = WindowConfig(swarm_particles=2, swarm_iterations=1, swarm_max_step=0.5, seed=seed)
        start = np.random.default_rng(seed).random((2, 2), dtype=np.float32).T * 100
        way.append(np.abs(Swarm(config).search(velocity) - start).max(axis=1).min())
    assert max(way) <= 0.5001


@pytest.mark.parametrize('random', [True, False])
def test_without_random_numbers_the_document_s_swarm_still_finds_its_way(random):
    velocity = np.random.default_rng(2).normal(size=(5, 6, 2))
    found = Swarm(WindowConfig(swarm_random=random, swarm_iterations=20)).search(velocity)
    np.testing.assert_allclose(found, velocity.mean(axis=1), atol=0.3)
