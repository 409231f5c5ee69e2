"""Stamps of pictures and of odometry that are apart by a constant that nobody tells."""

from dataclasses import replace
import sys

import numpy as np
import pytest
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

import world_scene
import world_strangers
import world_wrong

from colortrack_ros.world import LocatorConfig
from colortrack_ros.world.belief import Belief
from colortrack_ros.world.course import way_at
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.measurement import predicted
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.poses import TransformError
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.timing import FARTHER_APART
from colortrack_ros.world.timing import LIKELIER
from colortrack_ros.world.timing import Timing
from colortrack_ros.world.view import View

MOUNT = Pose.of_rpy((0.1, 0.05, 0.5), (0.1, 0.25, 0.2))
TIME = 8
SIGMA = 0.001


@pytest.mark.parametrize('sigma', [SIGMA, 0.02])
@pytest.mark.parametrize('share', [0.02, 0.3, 0.9])
def test_stamps_are_farther_apart_where_that_is_a_hundred_times_as_likely(sigma, share):
    """Share: how much of the variance that is expected is left."""
    variance, farther = share * sigma**2, []
    noise = variance / (1 - share)  # of the measurement that has left it
    for mean in np.linspace(0, 10 * sigma, 400):
        z = mean / (1 - share)
        spreads = np.hypot((sigma, FARTHER_APART), noise**0.5)
        narrow, wide = -np.log(spreads) - np.square(z / spreads) / 2  # of normal variables
        farther.append(wide - narrow > LIKELIER)
        assert Timing(sigma, 1, print)._farther(mean, variance) == farther[-1]
    assert set(farther) == {False, True}


def robot_at(stamp):
    """A robot that drives along an arc and climbs, at a time [ns]."""
    t = 1e-9 * stamp
    turn = 1.1 * t + 0.3 * t * t
    return Pose.of_rpy((0.5 * np.sin(t), 0.5 * np.cos(t), 0.1 * t), (0.05, 0.1 * t, turn))


def view_at(stamp):
    base = robot_at(stamp)
    return View(world_scene.CAMERA, base, MOUNT, way_at(robot_at, stamp, base))


def config(**told):
    return replace(world_scene.config_of('ground', 'rests'), **told)


def test_a_picture_that_is_stamped_early_is_expected_where_the_robot_is_by_then():
    early, kinds = 0.01, Kinds.of(config())
    view, later = (view_at(10**9 + round(1e9 * t)) for t in (0, early))
    point = later.optical.apply(np.array([[0.2, 0.1, 3.0]]))
    errors = np.zeros((1, 9))
    errors[0, TIME] = early
    state = np.concatenate([point, np.zeros((1, 5))], axis=1)
    _, found = predicted(view, state, errors, kinds, 0.0)
    right, _ = expected(later, np.append(state, np.zeros((1, 8)), 1), kinds.diameter, 0.1)
    _, wrong = predicted(view, state, np.zeros((1, 9)), kinds, 0.0)
    assert np.abs(wrong[..., -1] - right)[0, :2].max() > 3
    np.testing.assert_allclose(found[0, :2, -1], right[0, :2], atol=0.1)
    np.testing.assert_allclose(
        early * found[0, :2, TIME], right[0, :2] - wrong[0, :2, -1], atol=0.1
    )


def test_what_moves_is_expected_where_it_is_when_another_camera_sees_it():
    """Before a robot that stands, only this tells that stamps of two cameras are apart."""
    stands = View(world_scene.CAMERA, robot_at(0), MOUNT, np.zeros(6))
    kinds, errors, step = Kinds.of(config()), np.zeros((1, 18)), 1e-5
    errors[0, 16:] = -0.02, 0.03
    state = np.zeros((1, 8))
    state[:, :3], state[:, 3:5] = stands.optical.apply(np.array([[0.2, 0.1, 3.0]])), (0.4, -1.0)
    later = np.append(state, np.zeros((1, 8)), 1)
    later[0, :3] += 0.05 * later[0, 3:6]
    right, _ = expected(stands, later, kinds.diameter, 0.1)
    by_state, found = predicted(stands, state, errors, kinds, 0.0, camera=1)
    np.testing.assert_allclose(found[0, :, -1], right[0], atol=1e-9)
    rows = [0, 1, 4]  # of sizes, the slope leaves out how the lens changes
    _, moved = predicted(stands, state, errors + step * np.eye(18)[17], kinds, 0.0, camera=1)
    slope = (moved - found)[0, rows, -1] / step
    np.testing.assert_allclose(found[0, rows, 17], slope, rtol=1e-4)
    np.testing.assert_allclose(found[0, rows, 16], -slope, rtol=1e-4)
    _, moved = predicted(stands, state + step * np.eye(8)[3], errors, kinds, 0.0, camera=1)
    np.testing.assert_allclose(
        by_state[0, rows, 3], (moved - found)[0, rows, -1] / step, rtol=1e-3, atol=1e-3
    )


def test_how_a_robot_moves_is_known_from_its_poses():
    way = view_at(10**9).way
    turns = robot_at(10**9).inverse() @ robot_at(10**9 + 10**5)
    np.testing.assert_allclose(way, [*turns.t / 1e-4, *turns.turn / 1e-4], atol=0.02)


def test_at_the_first_pose_it_is_not_known():
    def poses(stamp):
        if stamp < 10**9:
            raise TransformError('none')
        return robot_at(stamp)

    assert way_at(poses, 10**9, robot_at(10**9)) is None
    chord = way_at(poses, 1_060_000_000, robot_at(1_060_000_000))
    np.testing.assert_allclose(chord, view_at(1_060_000_000).way, atol=0.1)


def test_what_began_before_it_was_known_how_the_robot_moves_depends_on_the_time_as_well():
    kinds, begun = Kinds.of(config()), []
    for view in (view_at(10**9), replace(view_at(10**9), way=None)):
        belief, rng = Belief.of(config()), np.random.default_rng(0)
        truth = np.zeros((1, 16))
        truth[0, :3] = view.optical.apply(np.array([[0.2, 0.1, 2.0]]))
        truth[0, 2] = 0.1
        measured, _ = world_scene.measure(view, truth, kinds, 'ground', 'rests', rng)
        belief.extend(belief.started(truth[:, :3], np.array([20.0]), measured, view, kinds, 0.0))
        begun.append(belief)
    assert not begun[1].motion.slope[..., TIME].any()
    Timing(SIGMA, 1, print).changes(begun[1], view_at(10**9), 0)
    known, unknown = (belief.motion.slope[:, :, :3, TIME] for belief in begun)
    np.testing.assert_allclose(unknown, known, rtol=1e-6, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize('method', ['ground', 'size'])
@pytest.mark.parametrize(('old', 'told'), [(0.05, 'early'), (-0.05, 'late')])
def test_stamps_that_are_apart_are_told_and_taken_into_account(old, told, method):
    robot = world_strangers.ROBOTS[f'odometry 50 ms {"old" if old > 0 else "ahead"}']
    rows, silent, lines = world_strangers.once(robot, method, 41)
    assert not silent
    assert 'restart' in lines[0]
    assert f'stamps of pictures are 0.05 s {told}' in lines[1] or '0.04 s' in lines[1]
    outside = rows[:, 2] > world_strangers.OUTSIDE
    assert outside[rows[:, 0] > 1].mean() < 0.02
    assert outside.mean() < 0.2


@pytest.mark.slow
def test_if_they_may_be_apart_as_configured_nothing_starts_anew():
    robot = replace(world_strangers.ROBOTS['odometry 50 ms old'], rate_told={'stamp_sigma': 0.05})
    rows, _, lines = world_strangers.once(robot, 'ground', 41)
    assert (rows[:, 2] > world_strangers.OUTSIDE).mean() < 0.02
    assert ['restart' in line for line in lines] == [False]


@pytest.mark.slow
@pytest.mark.parametrize('name', ['as usual', 'bounces off walls', 'odometry at 5 Hz'])
def test_of_right_stamps_nothing_is_told(name):
    _, _, lines = world_strangers.once(world_strangers.ROBOTS[name], 'ground', 41)
    assert not any('stamps' in line for line in lines)


@pytest.mark.slow
def test_stamps_of_two_cameras_that_are_apart_are_told_before_a_robot_that_stands():
    """By what rolls; before, heights of objects were said to be off after a second or more."""
    wrong = world_wrong.WRONG['stamps 50 ms late, 30 ms early']
    out = world_wrong.Run(wrong, 'two cameras', 'stands', 501).outcome()
    assert 'or those of other cameras, better if their stamps are apart' in out.line
    assert out.when < 1
    assert not out.silent


@pytest.mark.parametrize('sigma', [SIGMA, 0.0])
def test_a_robot_that_all_but_stands_tells_nothing_of_the_time(sigma):
    """Of 1e-12 m/s by a filter that comes to rest: rounding moves the mean, and nothing is known
    better; dividing by what was learned, each picture was a fault."""
    belief = Belief.of(LocatorConfig(stamp_sigma=sigma), 1)
    belief.errors.mean[:, TIME] = 1e-12
    timing = Timing(sigma, 1, pytest.fail)
    assert not timing.changes(belief, view_at(10**9), 0)
