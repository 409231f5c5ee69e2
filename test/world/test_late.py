"""Odometry that is late is told by one thing that is said to stand; what rolls or nods is not."""

from dataclasses import replace

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
from colortrack_ros.world.mistakes import LOOKS_BACK
from colortrack_ros.world.view import View

CAMERA = CameraModel.of(640, 480, (520, 0, 320, 0, 520, 240, 0, 0, 1))
MOUNT = Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0))
RATE, SECONDS = 10, 3.0
LATE = 'the time of odometry (positive: it is old) is off by about '


def x_at(t):
    """Where a robot is that speeds up to 0.6 m/s, by 1 m/s^2 from time 0 on [m]."""
    speeding = np.clip(t, 0, 0.6)
    return speeding**2 / 2 + 0.6 * max(t - 0.6, 0)


def told(old=0.0, nods=0.0, rolls=0.0, starts=0.5, hides=SECONDS, seconds=SECONDS):
    """What a locator tells of a ball that is said to stand, and when [s].

    :param old: of odometry [s]; nods: pitch as the robot speeds up [rad]; rolls: the ball [m/s].
    :param starts: time when the robot does [s]; hides: when the ball is no longer seen [s].
    """
    rng, lines, times = np.random.default_rng(0), [], []
    kind = Kind('red', KindConfig(height=RADIUS, motion='still'))
    locator = Locator(LocatorConfig(method='ground', colors=(kind,)), lines.append)
    for k in range(round(seconds * RATE)):
        t = k / RATE - starts
        lean = Pose.of_rpy((0, 0, 0), (0, -nods * (0 < t < 0.6), 0))
        ball = np.array([(2.6, 0.5 + rolls * max(t, 0), RADIUS)])
        there = View(CAMERA, Pose.of_rpy((x_at(t), 0, 0), (0, 0, 0)) @ lean, MOUNT)
        tracks, detections = seen(there, ball, (k + 1) * 10**9 // RATE)
        for name in 'uv':
            detections.rows[name] += 0.3 * rng.normal()
        view = View(CAMERA, Pose.of_rpy((x_at(t - old), 0, 0), (0, 0, 0)), MOUNT)
        if k / RATE > hides:
            tracks, detections = (
                replace(some, rows=some.rows[:0]) for some in (tracks, detections)
            )
        locator.update(tracks, detections, view)
        times += [k / RATE] * (len(lines) - len(times))
    assert locator.doubt == ''
    return [(line, t) for line, t in zip(lines, times, strict=True) if line.startswith(LATE)]


@pytest.mark.slow
@pytest.mark.parametrize('old', [0.2, -0.2])
def test_odometry_that_is_old_is_told_as_the_robot_speeds_up(old):
    (line, _), *_ = told(old)
    assert float(line[len(LATE) :].split()[0]) == pytest.approx(old, abs=0.1)


def test_it_is_told_no_longer_once_nothing_that_stands_has_been_seen_for_long():
    hidden = 1.6
    times = [t for _, t in told(0.2, hides=hidden, seconds=hidden + LOOKS_BACK + 3)]
    assert hidden < max(times) < hidden + LOOKS_BACK + 1


RIGHT = (
    {'nods': 0.02},
    {'nods': 0.01, 'starts': -0.3},
    {'nods': 0.02, 'starts': -0.3},
    {'rolls': 0.1},
)


@pytest.mark.slow
@pytest.mark.parametrize('right', RIGHT)
def test_a_robot_that_nods_and_a_ball_that_rolls_are_not_told_to_be_old_odometry(right):
    assert told(**right) == []
