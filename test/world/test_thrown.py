"""Balls that rest until somebody throws or kicks them."""

import sys

import numpy as np
import pytest
from support.balls_seen import RADIUS
from support.balls_seen import seen
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

import world_scene
from world_scene import CAMERA
from world_scene import DT
from world_scene import MOUNT
import world_told

from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.filter import update
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import U
from colortrack_ros.world.measurement import V
from colortrack_ros.world.motion import FLIGHTS
from colortrack_ros.world.motion import predict
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import GRAVITY
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import MOVES
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.view import View

VIEW = View(CAMERA, Pose.of_rpy((0, 0, 0), (0, 0, 0)), MOUNT)
REST = 1.5
"""How long it rests [s]."""


def thrown(t, first, speed):
    """Position and velocity of a ball that leaves where it was first at a time of 0 [s]."""
    t = max(t, 0.0)
    x, y, z = first
    x, y = x + speed[0] * t, y + speed[1] * t
    return (x, y, z + speed[2] * t - GRAVITY * t**2 / 2), (*speed[:2], speed[2] - GRAVITY * t)


@pytest.mark.slow
@pytest.mark.parametrize('rate', [10, 30, 60])
@pytest.mark.parametrize('speed', [(0, 0, 4.0), (0.4, -0.8, 3.0), (1.5, 0.5, 3.0)])
def test_a_ball_at_rest_that_is_thrown_is_followed_at_once(rate, speed):
    """To a third of a meter, and as far off as its covariance says."""
    told, kind = [], Kind('red', KindConfig(diameter=2 * RADIUS, motion='free_fall'))
    one = Locator(LocatorConfig(colors=(kind,)), told.append)
    off, weighed = [], []
    for k in range(int((REST + 0.6) * rate)):
        t = k / rate - REST
        at, velocity = thrown(t, (3.0, 0.1, RADIUS), speed)
        (row,) = one.update(*seen(VIEW, at, round((k + 1) * 1e9 / rate)), VIEW).rows
        if t > 0:
            e = np.array([row[name] for name in ('x', 'y', 'z')]) - at
            off.append(np.linalg.norm(e))
            weighed.append(e @ np.linalg.solve(row['covariance'].reshape(6, 6)[:3, :3], e))
    assert max(off) < 0.35
    assert np.mean(weighed) < 5
    last = np.array([row[name] for name in ('vx', 'vy', 'vz')])
    np.testing.assert_allclose(last, velocity, atol=0.3)
    assert told == []


SEEN = np.zeros(1, bool)
"""Of the one object: it has been seen in the last picture."""


def flying(height, count):
    """States of a ball 3 m away, its kind, a camera without errors, and as many truths."""
    config = world_scene.config_of('depth', 'bounces')
    errors = CameraErrors.of(config)
    errors.cov[:] = 0.0
    mean, slope = np.zeros((1, 2, OF_OBJECT)), np.zeros((1, 2, OF_OBJECT, len(errors.first)))
    mean[..., 0], mean[..., 2] = 3.0, height
    sigma = np.array([0.02, 0.02, 0.01, 0.05, 0.05, 0.05, 0.0, 0.0])
    cov = np.tile(np.diag(np.square(sigma)), (1, 2, 1, 1))
    truth = np.zeros((count, 16))
    truth[:, :OF_OBJECT] = mean[0, 0] + sigma * np.random.default_rng(0).normal(size=(count, 8))
    objects = Motions.of(mean, slope, cov, np.array([[0.0, 1.0]]))
    return objects, Kinds.of(config), errors, truth


def step(truth, kinds, errors, rng):
    """One step of truths, as told."""
    each, sight = kinds.take(np.zeros(len(truth), int)), np.zeros(len(truth), bool)
    world_told.moved_as_told(truth, each, errors, 1, DT, sight, rng)
    truth[:, OF_OBJECT:] = 0.0


@pytest.mark.slow
def test_a_ball_that_lies_out_of_sight_may_have_been_thrown():
    """Of as many as are told, after a second and two: NEES of 6 states."""
    objects, kinds, errors, truth = flying(RADIUS, 20_000)
    rng = np.random.default_rng(1)
    for k in range(1, 61):
        predict(objects, errors, kinds, 0.0, DT, ~SEEN)
        step(truth, kinds, errors, rng)
        if k % 30 == 0:
            mean, cov = objects.combined(errors)
            e = truth[:, :6] - mean[:, :6]
            assert 4.5 < (e * np.linalg.solve(cov[0, :6, :6], e.T).T).sum(axis=1).mean() < 6.3


@pytest.mark.slow
def test_a_throw_too_late_in_a_step_to_be_seen_at_once_is_not_ruled_out(monkeypatch):
    """Of balls that are seen as if they flew on, so much more may vertical speeds be off by."""
    objects, kinds, errors, truth = flying(1.0, 200_000)
    predict(objects, errors, kinds, 0.0, DT, SEEN)
    each, rng, sides = kinds.take(np.zeros(len(truth), int)), np.random.default_rng(1), []
    for mean_time in (np.inf, 1e-9):
        monkeypatch.setattr(world_told, 'FLIGHTS', mean_time)
        moved = truth.copy()
        step(moved, kinds, errors, rng)
        measured, _ = world_scene.measure(VIEW, moved, each, 'depth', 'bounces', rng)
        if not sides:
            z, sigma = measured.z.mean(axis=0), measured.z.std(axis=0)
        of = [U, V, DEPTH]
        alike = (np.abs(measured.z - z)[:, of] < sigma[of] / 2).all(axis=1)
        sides.append(np.square(moved[alike, 5] - objects.mean[0, MOVES, 5]))
    chance = (1 - np.exp(-DT / FLIGHTS)) * len(sides[1]) / len(sides[0])
    one = measured.take(np.zeros(1, int))
    one.z[:] = z
    update(objects, errors, one, VIEW, kinds, 0.0)
    more = objects.combined(errors)[1][0, 5, 5] - objects.cov[0, MOVES, 5, 5]
    assert 0.6 < more / (chance * (np.mean(sides[1]) - np.mean(sides[0]))) < 1.6


@pytest.mark.slow
@pytest.mark.parametrize('up', [5.0, 6.0, 7.0, 8.0])
def test_a_ball_whose_throw_is_refused_at_first_is_not_lost(up):
    """Of 1 m/s, and up as much as 3 m/s; from 0.1 s on it is as far off as its covariance says."""
    kind = Kind('red', KindConfig(diameter=2 * RADIUS, motion='free_fall', speed=1.0))
    one, rate, weighed = Locator(LocatorConfig(colors=(kind,)), lambda line: None), 60, []
    rng = np.random.default_rng(0)
    for k in range(int(1.25 * rate)):
        t = k / rate - 1.0
        at, _ = thrown(t, (3.5, 0.1, RADIUS), (0.6, 0.5, up))
        tracks, detections = seen(VIEW, at, round((k + 1) * 1e9 / rate))
        detections.rows['u'] += 0.3 * rng.normal()
        (row,) = one.update(tracks, detections, VIEW).rows
        if t > 0.1:
            e = np.array([row[name] for name in ('x', 'y', 'z')]) - at
            weighed.append(e @ np.linalg.solve(row['covariance'].reshape(6, 6)[:3, :3], e))
    assert np.mean(weighed) < 5
