"""What the cases of the pitch are told by objects that roll."""

import sys

import numpy as np
import pytest
from scipy.special import chdtri
from support.balls_seen import FRAME
from support.balls_seen import seen
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

import world
import world_scene

from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.view import View

CAMERA = CameraModel.of(320, 240, (260, 0, 159.5, 0, 260, 119.5, 0, 0, 1))
MOUNT = Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0))
VIEW = View(CAMERA, Pose.of_rpy((0, 0, 0), (0, 0, 0)), MOUNT)
STANDS = 4.1, -1.2, 0.1


def test_a_ball_that_rolls_straight_before_a_robot_that_stands_tells_nothing_of_its_pitch():
    """It was taken to be far away, as it would roll so evenly in pixels there: 0.6 m for both."""
    kind = Kind('red', KindConfig(diameter=0.2))
    one = Locator(LocatorConfig(colors=(kind,)), lambda _: None)
    for k in range(60):
        rolls = 2.3 + 0.4 * k * FRAME * 1e-9, 0.0, 0.1
        out = one.update(*seen(VIEW, [rolls, STANDS], (k + 1) * FRAME), VIEW)
    away = np.hypot(out.rows['x'] - [rolls[0], STANDS[0]], out.rows['y'] - [rolls[1], STANDS[1]])
    assert (away < 0.1).all()
    # the pitch is as uncertain as before: 0.01 rad at 4.2 m, 0.4 m above
    spread = np.sqrt(np.linalg.eigvalsh(out.rows['covariance'][1].reshape(6, 6)[:2, :2])[-1])
    assert 0.4 < spread < 0.55


@pytest.mark.slow
def test_a_ball_that_is_picked_up_before_a_robot_that_stands_tells_nothing_of_its_pitch():
    """It speeds up as nothing on the ground does: 2 degrees were learned, and taken for certain."""
    kind = Kind('red', KindConfig(diameter=0.2))
    one = Locator(LocatorConfig(colors=(kind,)), lambda _: None)
    view = View(CAMERA, VIEW.base, MOUNT, np.zeros(6))
    for k in range(60):
        height = 0.1 + 0.6 * np.sin(np.pi / 2 * np.clip((k - 10) / 40, 0, 1)) ** 2
        out = one.update(*seen(view, [(2.3, 0.0, height), STANDS], (k + 1) * 2 * FRAME), view)
    row = out.rows[out.rows['track_id'] == 2][0]
    assert np.hypot(row['x'] - STANDS[0], row['y'] - STANDS[1]) < 0.1
    spread = np.sqrt(np.linalg.eigvalsh(row['covariance'].reshape(6, 6)[:2, :2])[-1])
    assert 0.4 < spread < 0.55


def test_a_ball_above_the_horizon_of_one_case_is_not_taken_to_be_behind_the_camera():
    """Covariances there had negative variances, and in the end all objects were at nan."""
    sigma = 0.01, 0.01, 0.01, 0.01, 0.01745, 0.01
    config = LocatorConfig(colors=(Kind('red', KindConfig(diameter=0.2)),), camera_pose_sigma=sigma)
    one, noise = Locator(config, lambda _: None), np.random.default_rng(559).normal(size=(45, 2))
    seen_by = View(CAMERA, VIEW.base, Pose.of_rpy((0.1, 0, 0.5), (0, 0.273, 0)))
    view = View(CAMERA, VIEW.base, MOUNT, np.zeros(6))
    for k in range(30):
        t = k / 15
        x = 3.22 + 4.53 * t - 0.31 * t * t / 2
        y, z = np.array([0.21 * t, 0.1]) + 0.002 * x * noise[k]
        one.update(*seen(seen_by, [(x, y, z), STANDS], (k + 1) * 2 * FRAME), view)
        assert one._objects.belief.in_front(view).all()


@pytest.mark.slow
def test_balls_that_roll_evenly_tell_a_robot_that_stands_nothing_of_its_pitch(monkeypatch):
    """They were twice as far off as 1 degree of pitch lets them be: 43 % of the range."""
    monkeypatch.setattr(world, 'config_of', lambda *_: world_scene.config_of('ground', 'rests'))
    monkeypatch.setitem(world_scene.SPEED, 'rolls', (0.2, 0.2, 0.0))
    monkeypatch.setitem(world_scene.WANDER, 'rolls', 0.0)
    out = world.run('ground', 'rolls', False, runs=40, seed=3)
    assert out.rmse() < 0.25
    assert np.mean(out.nees[out.counted > 0] < chdtri(4, 0.05)) > 0.9
