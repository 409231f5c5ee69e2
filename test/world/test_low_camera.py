"""A camera little above the centers of objects: its height bends ranges as its pitch does."""

import sys

import numpy as np
import pytest
from support.balls_seen import FRAME
from support.balls_seen import seen
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

import world
import world_scene

from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world.belief import Belief
from colortrack_ros.world.cases import CASE_PITCHES
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

LOW = world_scene.ELSEWHERE['low, level, near']


@pytest.mark.slow
def test_before_a_robot_that_drives_covariances_hold():
    out = world.run('ground', 'stands', True, runs=60, seed=4141, scene=LOW)
    assert out.mean_nees < out.bounds[1]


@pytest.mark.slow
def test_no_case_in_which_an_object_is_above_the_horizon_prevails():
    """It fits once the object's height was learned from there; what was before still counts."""
    out = world.run('ground', 'stands', False, runs=40, seed=4141, scene=LOW)
    assert out.mean_nees < out.bounds[1]


@pytest.mark.slow
@pytest.mark.parametrize('seed', [21, 717])
def test_a_camera_that_stands_learns_nothing_as_its_errors_change(seed):
    """It stands 6 s, in which errors change by 6 % of their deviations, half a pixel."""
    out = world.run('ground', 'stands', False, runs=30, seed=seed, scene=LOW, as_told=True)
    assert out.bounds[0] < out.mean_nees < out.bounds[1]


def test_cases_of_the_height_are_those_of_low_cameras_only():
    config = world_scene.config_of('ground', 'stands')
    kinds, count = Kinds.of(config), len(CASE_PITCHES)
    for height, cases in ((0.2, count**2), (0.5, count)):
        mount = Pose.of_rpy((0, 0, height), (0, 0.2, 0))
        view = View(world_scene.CAMERA, Pose.of_rpy((0, 0, 0), (0, 0, 0)), mount)
        belief, truth = Belief.of(config), np.zeros((1, 16))
        truth[:, :3] = [[1.0, 0.0, 0.1]]
        rng = np.random.default_rng(0)
        measured, seen = world_scene.measure(view, truth, kinds, 'ground', 'stands', rng)
        assert seen.all()
        reach = np.full(1, 10.0)
        begun = belief.started(truth[:, :3], reach, measured, view, kinds, 0.0)
        assert len(begun.log_weight) == len(belief.log_weight) == cases
        assert len(begun) == 1


@pytest.mark.slow
@pytest.mark.filterwarnings('error')
def test_a_level_camera_as_high_as_the_object_is_computed_with_numbers():
    """One of the wrong setups that are tried looks straight down, from the object's own height."""
    view = View(
        world.CAMERA, Pose.of_rpy((0, 0, 0), (0, 0, 0)), Pose.of_rpy((0, 0, 0.1), (0, 0, 0))
    )
    told = []
    kind = Kind('red', KindConfig(diameter=0.2))
    one = Locator(LocatorConfig(method='ground', colors=(kind,)), told.append)
    for k in range(60):
        one.update(*seen(view, (3.0, 0.0, 0.1), (k + 1) * FRAME), view)
    assert 'its ray does not meet the ground' in told[0]
