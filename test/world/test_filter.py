from functools import cache
import sys

import numpy as np
import pytest
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

import world
import world_scene

from colortrack_ros.world.belief import Belief
from colortrack_ros.world.config import RANGE_METHODS
from colortrack_ros.world.filter import started
from colortrack_ros.world.filter import update
from colortrack_ros.world.flight import FALLS
from colortrack_ros.world.flight import RESTITUTION
from colortrack_ros.world.inverse_depth import from_points
from colortrack_ros.world.inverse_depth import to_points
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.measurement import ranges_by_size
from colortrack_ros.world.motion import predict
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import GRAVITY
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import MOVES
from colortrack_ros.world.view import View
from colortrack_ros.world.whitening import whitening

run = cache(world.run)
VIEW = View(world_scene.CAMERA, Pose.of_rpy((1, 2, 0), (0, 0, 0.5)), world_scene.MOUNT)
SEEN = np.zeros(1, bool)
"""Of the one object: it has been seen in the last picture."""


BY_TURNS = [
    pytest.param(method, motion, drives, id=f'{method}-{motion}-{"drives" if drives else "stands"}')
    for i, method in enumerate(RANGE_METHODS)
    for k, motion in enumerate(world_scene.MOTIONS)
    for drives in [(i + k) % 2 > 0]
]
"""Each method with each motion, and each of both before a robot that stands and one that drives."""


@pytest.mark.slow
@pytest.mark.parametrize(('method', 'motion', 'drives'), BY_TURNS)
def test_the_covariance_says_how_far_off_the_object_is(method, motion, drives):
    """50 runs in which all happens that is told, as only then NEES is as expected.

    Of what stands, half of what pictures tell of the camera is counted, so covariances may be
    larger.
    """
    outcome = world.run(method, motion, drives, runs=50, seed=7, as_told=True)
    low, high = outcome.bounds
    if motion == 'stands':
        low -= 0.6 if drives else 0.35
    assert low < outcome.mean_nees < high


@pytest.mark.slow
@pytest.mark.parametrize(('name', 'most'), [('60 Hz', 5.0), ('straight down', 4.5)])
def test_what_rolls_slowly_is_not_taken_for_what_stands_before_a_camera_that_is_off(name, most):
    """As if it were, NEES is 5.4 at 60 Hz and 4.9 straight down, of 4 states."""
    scene = world_scene.ELSEWHERE[name]
    assert 3 < world.run('ground', 'rolls', True, runs=30, seed=21, scene=scene).mean_nees < most


@pytest.mark.slow
@pytest.mark.parametrize(
    ('method', 'drives'),
    [('ground', False), ('size', True), ('depth', False), ('fused', True)],
)
def test_a_robot_knows_where_things_stand_nearly_as_well_as_anybody_could(method, drives):
    """50 runs: their root mean square is known to 10 %."""
    error = run(method, 'stands', drives, runs=50, seed=7).rmse()
    variance, counted = world.bound(method, 'stands', drives, runs=50, seed=7)
    assert 0.7 < error / np.sqrt(np.mean(variance[counted > 0])) < 1.5


@pytest.mark.slow
@pytest.mark.parametrize(('method', 'most'), [('ground', 0.02), ('size', 0.04), ('depth', 0.011)])
def test_driving_for_2_seconds_shows_the_pitch_and_what_rests(method, most):
    outcome = run(method, 'rests', True, runs=50, seed=7)
    assert outcome.rmse(since=2.0) < most
    assert outcome.slow(since=1.0) > 0.95


@pytest.mark.slow
def test_an_error_of_the_pitch_is_not_averaged_away_by_looking_longer():
    config, rng = world_scene.config_of('ground', 'stands'), np.random.default_rng(0)
    kinds, errors = Kinds.of(config).take(np.zeros(1, int)), CameraErrors.of(config)
    truth = np.zeros((1, 16))
    truth[0, :3] = VIEW.base.apply(np.array([[4, 0, 0.1]]))
    measured, _ = world_scene.measure(VIEW, truth, kinds, 'ground', 'stands', rng)
    found = started(truth[:, :3], np.array([40.0]), measured, VIEW, kinds, errors, 0.0)
    for _ in range(300):
        predict(found, errors, kinds, 0.0, world_scene.DT, SEEN)
        measured, _ = world_scene.measure(VIEW, truth, kinds, 'ground', 'stands', rng)
        update(found, errors, measured, VIEW, kinds, 0.0)
    # 1 degree, at 3.9 m from a camera 0.4 m above the center: r^2 / h * sigma
    spread = np.sqrt(np.linalg.eigvalsh(found.combined(errors)[1][0, :2, :2])[1])
    assert spread == pytest.approx(
        (3.9**2 + 0.4**2) / 0.4 * np.radians(world_scene.PITCH), rel=0.15
    )
    assert np.diag(errors.cov[0]) == pytest.approx(np.diag(errors.first), rel=0.05)


def states(count=20):
    rng = np.random.default_rng(3)
    mean = np.zeros((count, 16))
    ahead = rng.uniform([1.5, -0.6, 0], [5, 0.6, 0.8], (count, 3))
    mean[:, :3] = VIEW.base.apply(ahead)
    mean[:, 6:] = 0.001 * rng.normal(size=(count, 10))
    return mean


def test_the_jacobian_of_what_is_expected_is_that_of_small_steps():
    mean, diameter, plane = states(), np.full(20, 0.2), np.full(20, 0.1)
    diameter[5] = 0.0
    _, H = expected(VIEW, mean, diameter, plane)
    for at in range(16):
        step = np.zeros(16)
        step[at] = 1e-6
        high, low = (expected(VIEW, mean + s, diameter, plane)[0] for s in (step, -step))
        numeric = (high - low) / 2e-6
        # H is taken without the biases themselves
        scale = np.abs(numeric).max(axis=0) + 1e-3
        scale[:2], scale[4] = scale[:2].max(), max(scale[4], 1.0)
        assert (np.abs(H[:, :, at] - numeric) / scale)[:, [0, 1, 2, 4]].max() < 0.03
    away = mean[:, :3] - VIEW.optical.t
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    step = np.zeros_like(mean)
    step[:, :3] = 1e-6 * away
    high, low = (expected(VIEW, mean + s, diameter, plane)[0][:, BLOB] for s in (step, -step))
    along = (H[:, BLOB, :3] * away).sum(axis=1)
    np.testing.assert_allclose(along, (high - low) / 2e-6, rtol=0.02, atol=1e-6)


def outline(q, rho, camera):
    """The pixels of the outline of a sphere: the cone of rays that touch it."""
    axis, half = q / np.linalg.norm(q), np.arcsin(rho / np.linalg.norm(q))
    side = np.cross(axis, [0, 1, 0])
    side /= np.linalg.norm(side)
    turn = np.linspace(0, 2 * np.pi, 2000, endpoint=False)[:, None]
    around = np.cos(turn) * side + np.sin(turn) * np.cross(axis, side)
    return camera.project(np.cos(half) * axis + np.sin(half) * around)


@pytest.mark.parametrize('q', [(0, 0, 1), (0.5, 0.3, 1.2), (-0.9, 0.5, 2), (1, -0.8, 3.5)])
def test_a_sphere_is_expected_where_and_as_large_as_it_is_seen(q):
    edge = outline(np.array(q), 0.1, world_scene.CAMERA)
    u, v = edge.T
    cross = u * np.roll(v, -1) - v * np.roll(u, -1)
    area = cross.sum() / 2
    center = [((a + np.roll(a, -1)) * cross).sum() / (6 * area) for a in (u, v)]
    mean = np.zeros((1, 16))
    mean[0, :3] = VIEW.optical.apply(np.array([q]))[0]
    z, _ = expected(VIEW, mean, np.array([0.2]), np.zeros(1))
    assert z[0, :2] == pytest.approx(center, abs=0.02 * z[0, BLOB])
    assert z[0, BLOB] == pytest.approx(np.sqrt(4 * abs(area) / np.pi), rel=0.01)
    rays = VIEW.camera.rays(z[:, :2])
    away = ranges_by_size(VIEW.camera, rays, z[:, BLOB], np.array([0.2]))
    assert away[0] == pytest.approx(np.linalg.norm(q), rel=0.02)


def test_inverse_depth_and_back_is_the_same_point():
    points = states()[:, :3]
    y, J = from_points(VIEW.optical, points)
    again, back = to_points(VIEW.optical, y)
    np.testing.assert_allclose(again, points)
    np.testing.assert_allclose(J @ back, np.broadcast_to(np.eye(3), J.shape), atol=1e-9)
    change = (from_points(VIEW.optical, points + np.array([1e-6, 0, 0]))[0] - y) / 1e-6
    np.testing.assert_allclose(J[:, :, 0], change, atol=1e-4)


def falling(height, speed):
    config = world_scene.config_of('size', 'bounces')
    kinds, errors = Kinds.of(config).take(np.zeros(1, int)), CameraErrors.of(config)
    found = Motions.of(
        np.zeros((1, 2, 8)), np.zeros((1, 2, 8, 9)), np.tile(1e-4 * np.eye(8), (1, 2, 1, 1)),
        np.array([[0.0, 1.0]]),
    )  # fmt: skip
    found.mean[..., 2], found.mean[:, MOVES, 5] = height, speed
    return found, errors, kinds


def test_what_fits_in_any_case_of_the_pitch_fits():
    config, rng = world_scene.config_of('ground', 'rolls'), np.random.default_rng(1)
    kinds, truth = Kinds.of(config), np.zeros((1, 16))
    truth[0, :3] = VIEW.base.apply(np.array([[2.5, 0, 0.1]]))
    measured, _ = world_scene.measure(VIEW, truth, kinds, 'ground', 'rolls', rng)
    belief = Belief.of(config).started(truth[:, :3], np.array([25.0]), measured, VIEW, kinds, 0.0)
    belief.motion.mean[0, :, :2] += 1.0
    assert belief.misfit(measured, VIEW, kinds, 0.0) < 1


def test_a_thrown_ball_falls_as_gravity_says():
    found, errors, kinds = falling(5.0, 2.0)
    kinds.drag[:] = 0.0
    for _ in range(30):
        predict(found, errors, kinds, 0.0, 1 / 30, SEEN)
    mean, _ = found.combined(errors)
    assert mean[0, 2] == pytest.approx(5 + 2 - 9.80665 / 2)
    assert mean[0, 5] == pytest.approx(2 - 9.80665)


def test_at_the_ground_it_bounces_and_is_less_certain():
    found, errors, kinds = falling(0.15, -4.0)
    predict(found, errors, kinds, 0.0, 1 / 30, SEEN)
    mean, cov = found.combined(errors)
    assert mean[0, 5] == pytest.approx(0.7 * (4 + 9.80665 / 30), rel=0.05)
    assert mean[0, 2] > 0.1
    assert np.sqrt(cov[0, 5, 5]) > 0.5
    assert np.linalg.eigvalsh(cov[0]).min() > -1e-12


def test_a_ball_that_bounces_out_of_sight_is_where_so_many_balls_are():
    """Heights and speeds of 10,000 that reach the ground after 0.03 s, by NEES of 2.

    If what has bounced is reflected again, the mean stays on the ground, where it never is.
    """
    found, errors, kinds = falling(0.2, -3.0)
    kinds.drag[:] = kinds.wander[:] = 0.0
    found.cov[..., 2, 2], found.cov[..., 5, 5] = 0.03**2, 0.3**2
    z, v = np.random.default_rng(0).normal([[0.2], [-3.0]], [[0.03], [0.3]], (2, 10_000))
    rng = np.random.default_rng(1)
    for _ in range(9):
        predict(found, errors, kinds, 0.0, 1 / 30, SEEN)
        z, v = z + v / 30 - GRAVITY / 1800, v - GRAVITY / 30
        down, share = (z < 0.1) & (v < 0), rng.normal(kinds.bounce, RESTITUTION, len(z))
        z, v = np.where(down, 0.1 + share * (0.1 - z), z), np.where(down, -share * v, v)
        mean, cov = (a[0, MOVES] for a in (found.mean, found.cov))
        off = np.stack([z, v]) - mean[FALLS, None]
        nees = (off * np.linalg.solve(cov[np.ix_(FALLS, FALLS)], off)).sum(axis=0).mean()
        assert abs(mean[2] - z.mean()) < 0.04
        assert 0.7 < nees < 2.2


def test_what_begins_to_roll_after_it_stood_is_seen_to_roll():
    config, rng = world_scene.config_of('size', 'rests'), np.random.default_rng(1)
    kinds, errors = Kinds.of(config).take(np.zeros(1, int)), CameraErrors.of(config)
    truth, speeds = np.zeros((1, 16)), []
    truth[0, :3] = VIEW.base.apply(np.array([[2.5, 0, 0.1]]))
    measured, _ = world_scene.measure(VIEW, truth, kinds, 'ground', 'stands', rng)
    found = started(truth[:, :3], np.array([25.0]), measured, VIEW, kinds, errors, 0.0)
    for k in range(120):
        truth[0, 1] += 0.4 * world_scene.DT * (k >= 60)
        measured, _ = world_scene.measure(VIEW, truth, kinds, 'ground', 'rolls', rng)
        predict(found, errors, kinds, 0.0, world_scene.DT, SEEN)
        update(found, errors, measured, VIEW, kinds, 0.0)
        speeds.append(np.linalg.norm(found.combined(errors)[0][0, 3:6]))
    assert max(speeds[30:60]) < 0.05
    assert speeds[75] == pytest.approx(0.4, abs=0.15)  # half a second later
    assert speeds[-1] == pytest.approx(0.4, abs=0.1)


@pytest.mark.parametrize('count', [1, 2, 3, 5])
def test_whitened_errors_are_independent_and_of_variance_1(count):
    rng = np.random.default_rng(count)
    A = rng.normal(size=(7, 2, count, count)) * 10.0 ** rng.uniform(-4, 4, count)[:, None]
    S = A @ A.swapaxes(-1, -2)
    W, volume = whitening(S)
    scale = np.sqrt(np.diagonal(S, axis1=-2, axis2=-1))
    back = np.linalg.inv(W)
    assert np.allclose(back @ back.swapaxes(-1, -2) / scale[..., None] / scale[..., None, :],
                       S / scale[..., None] / scale[..., None, :], atol=1e-9)  # fmt: skip
    assert np.array_equal(W, np.tril(W))
    assert np.allclose(volume, -np.linalg.slogdet(S)[1] / 2)
