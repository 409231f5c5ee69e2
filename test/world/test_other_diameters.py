"""Balls of another diameter than they are said to have, located by the ground."""

import numpy as np
import pytest
from scipy.special import chdtri
from support.balls_seen import RADIUS
from support.balls_seen import seen
from support.misled_robot import BALLS
from support.misled_robot import FRAME
from support.misled_robot import Robot
from support.misled_robot import view


def nees(share):
    """Of balls that are so much larger than told, in their first picture."""
    robot = Robot(told_diameter=2 * RADIUS, camera_pose_sigma=(0.002,) * 6)
    balls = BALLS * [1, 1, share]
    shown = seen(view(0, 0), balls, FRAME, radius=share * RADIUS)
    found = robot.locator.update(*shown, view(0, 0)).rows
    assert len(found) == len(BALLS)
    off = np.stack([found[axis] for axis in 'xyz'], axis=1) - balls
    cov = found['covariance'].reshape(-1, 6, 6)[:, :3, :3]
    return (off * np.linalg.solve(cov, off[..., None])[..., 0]).sum(axis=1)


@pytest.mark.parametrize('share', [0.85, 1.2])
def test_covariances_reach_to_where_balls_lie_that_are_smaller_or_larger_than_told(share):
    assert (nees(share) < chdtri(3, 0.5)).all()


def test_covariances_of_balls_as_large_as_told_are_those_of_the_ground_alone(monkeypatch):
    as_told = nees(1.02)
    monkeypatch.setattr('colortrack_ros.world.doubts.other_diameters', lambda *_: {})
    np.testing.assert_allclose(as_told, nees(1.02), rtol=0.02)
