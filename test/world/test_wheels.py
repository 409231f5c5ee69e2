"""Wheels of another radius: told by how much they may be off, covariances hold, and it is named."""

from dataclasses import replace
import sys

import numpy as np
import pytest
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

import world
import world_odometry

from colortrack_ros.world.belief import Belief
from colortrack_ros.world.consistency import inconsistency


@pytest.mark.slow
@pytest.mark.parametrize('method', ['ground', 'size', 'depth', 'fused'])
def test_what_stands_is_where_it_is_said_to_be(method):
    told = world.run(method, 'stands', True, runs=20, seed=31, ways=0.05)
    untold = world.run(method, 'stands', True, runs=20, seed=31, ways=0.05, told=0.0)
    assert told.mean_nees < told.bounds[1]
    assert told.mean_nees < untold.mean_nees / 5
    assert told.rmse(world.SETTLED) < untold.rmse(world.SETTLED)


@pytest.mark.slow
def test_what_rolls_is_located_as_well_as_before():
    known = world.run('size', 'rolls', True, runs=10, seed=31)
    unknown = world.run('size', 'rolls', True, runs=10, seed=31, told=0.05)
    assert unknown.mean_nees < unknown.bounds[1]
    assert unknown.rmse() == pytest.approx(known.rmse(), rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize('wheels', ['way 0.9', 'right'])
def test_places_of_a_whole_locator_are_within_their_ellipses(wheels):
    outs = [
        world_odometry.run('three stand', 'straight', wheels, seed, wheels=0.05)
        for seed in (40, 41)
    ]
    rows, untold, told, _ = sum(out.rows for out in outs)
    assert rows > 500
    assert untold == told == 0
    assert not any(out.line for out in outs)


def test_a_scale_far_beyond_what_was_told_is_named():
    config = replace(world_odometry.config_of('ground', 'rests'), way_sigma=0.02)
    belief = Belief.of(config)
    belief.errors.mean[:, -1], belief.errors.cov[:, -1, -1] = 0.15, 1e-6
    assert 'the scale of ways by odometry is off by +15 %' in inconsistency(belief, 0, NO_SIZES)


def test_without_it_the_errors_are_those_of_the_camera_alone():
    belief = Belief.of(world_odometry.config_of('ground', 'rests'))
    assert belief.errors.mean.shape[1] == 9  # and of the time of its pictures
    assert not belief.errors.scaled


class NoSizes:
    seen = expected = np.zeros(0)
    cov = np.zeros((0, 0))


NO_SIZES = NoSizes()
