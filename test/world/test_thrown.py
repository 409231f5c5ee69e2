"""Balls that rest until somebody throws or kicks them."""

import sys

import numpy as np
import pytest
from support.balls_seen import RADIUS
from support.balls_seen import seen
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

from world import CAMERA
from world import MOUNT

from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.state import GRAVITY
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
