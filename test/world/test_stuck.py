"""Odometry that is stuck while the robot turns is told; what rolls past one that stands is not."""

import numpy as np
import pytest
from support.balls_seen import RADIUS
from support.balls_seen import seen

from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.poses import NO_ROBOT
from colortrack_ros.world.view import View

CAMERA = CameraModel.of(640, 480, (520, 0, 320, 0, 520, 240, 0, 0, 1))
MOUNT = Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0))
FRAME = 33_333_333
BALLS = np.array([(2.0, 0.4, RADIUS), (3.5, -0.4, RADIUS), (4.0, 0.2, RADIUS)])
STUCK = 'odometry stands while all that is seen turns by'


def told(way, odometry, balls=lambda t: BALLS, pictures=75):
    """The lines of a locator; way and odometry are poses by the time [s]."""
    lines, rng = [], np.random.default_rng(0)
    kind = Kind('red', KindConfig(height=RADIUS))
    locator = Locator(LocatorConfig(method='ground', colors=(kind,)), lines.append)
    for k in range(pictures):
        t = k * FRAME / 1e9
        tracks, detections = seen(View(CAMERA, way(t), MOUNT), balls(t), (k + 1) * FRAME)
        for name in 'uv':
            detections.rows[name] += 0.5 * rng.normal(size=len(detections.rows))
        locator.update(tracks, detections, View(CAMERA, odometry(t), MOUNT))
    return [line for line in lines if STUCK in line]


def stands(t):
    return Pose.of_rpy((1, 2, 0), (0, 0, 0.5))


def swings(speed, drives=0.0):
    """A robot that turns to and fro from where it stands, and drives [rad/s, m/s]."""
    return lambda t: (
        stands(t) @ Pose.of_rpy((drives * t, 0, 0), (0, 0, 0.25 * np.sin(speed * t / 0.25)))
    )


def of_robot(balls):
    """Balls by the time in the frame of the robot as it stands."""
    return lambda t: stands(t).apply(balls(t))


SEEN = of_robot(lambda t: BALLS)


@pytest.mark.parametrize('drives', [0.0, 0.4])
@pytest.mark.parametrize('speed', [0.8, -1.0])
def test_odometry_that_stands_while_the_robot_turns_is_told_with_the_turn(speed, drives):
    lines = told(swings(speed, drives), stands, SEEN)
    assert lines
    first = float(lines[0].split(STUCK)[1].split()[0])
    assert abs(first) < np.degrees(abs(speed)) * 1.2


@pytest.mark.parametrize('drives', [0.0, 0.4])
def test_odometry_that_is_right_is_not_told(drives):
    way = swings(0.8, drives)
    assert not told(way, way, SEEN)


def test_a_robot_that_stands_before_what_rolls_is_not_told():
    """Two roll to the left at 0.5 m/s, one beside the other, and one stands."""
    rolls = np.array([(0, 0.5, 0), (0, 0.5, 0), (0, 0, 0)])
    assert not told(stands, stands, of_robot(lambda t: BALLS - [0, 0.6, 0] + t * rolls))


@pytest.mark.slow
def test_a_camera_that_is_fixed_in_the_room_has_no_odometry():
    """On a belt, all move alike."""
    turns = swings(0.8)
    belt = lambda t: turns(t).inverse().apply(SEEN(t))  # noqa: E731
    assert not told(lambda t: NO_ROBOT, lambda t: NO_ROBOT, belt)
    at_origin = lambda t: Pose(np.zeros(3), np.eye(3))  # noqa: E731
    assert told(at_origin, at_origin, belt)
