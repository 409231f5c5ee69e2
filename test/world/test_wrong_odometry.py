"""Odometry that is wrong is told, and named where turns show it; what rolls alike is no mistake."""

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
from colortrack_ros.world.view import View

CAMERA = CameraModel.of(640, 480, (520, 0, 320, 0, 520, 240, 0, 0, 1))
MOUNT = Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0))
FRAME = 33_333_333
SECOND = 30
BALLS = np.array([(3.0, 0.8, RADIUS), (3.5, -0.5, RADIUS), (4.2, 0.3, RADIUS)])
SET_OFF = 'all that stood sets off at once'


def way(speed, turn, pictures):
    """The poses x, y, yaw, (pictures, 3), of a robot by its speeds, functions of the time [s]."""
    x = y = yaw = 0.0
    poses = []
    for k in range(pictures):
        poses.append((x, y, yaw))
        t = k * FRAME / 1e9
        yaw += turn(t) * FRAME / 1e9
        x += speed(t) * np.cos(yaw) * FRAME / 1e9
        y += speed(t) * np.sin(yaw) * FRAME / 1e9
    return np.array(poses)


def run(poses, odometry, balls=lambda t: BALLS):
    """The lines of a locator, and how many objects it publishes at last."""
    lines, rng = [], np.random.default_rng(0)
    kind = Kind('red', KindConfig(height=RADIUS))
    locator = Locator(LocatorConfig(method='ground', colors=(kind,)), lines.append)
    for k, places in enumerate(zip(poses, odometry, strict=True)):
        there, told = (Pose.of_rpy((x, y, 0), (0, 0, yaw)) for x, y, yaw in places)
        shown = inside(*seen(View(CAMERA, there, MOUNT), balls(k * FRAME / 1e9), (k + 1) * FRAME))
        tracks, detections = shown
        for name in 'uv':
            detections.rows[name] += 0.3 * rng.normal(size=len(detections.rows))
        found = locator.update(tracks, detections, View(CAMERA, told, MOUNT))
    return lines, len(found.rows)


def inside(tracks, detections):
    """Only what is wholly in the picture has a detection; the tracks of the others coast."""
    rows = detections.rows
    pixels = np.stack([rows['u'], rows['v']], axis=1)
    shown = (np.abs(pixels - [320, 240]) < [280, 200]).all(axis=1)
    tracks.rows['time_since_update'] = ~shown[::-1]
    return tracks, replace(detections, rows=rows[shown])


def none(t):
    return 0.0


def sets_off(t):
    return 0.4 * (t > 1.5)


def ahead_of(lines):
    """How far the robot has driven and turned by the first line, and by odometry [m, degrees]."""
    line = next(line for line in lines if SET_OFF in line)
    return [float(word) for word in line.replace(':', ' ').split() if word[0] in '+-']


@pytest.mark.slow
def test_odometry_that_stands_from_the_start_is_told_when_the_robot_drives_straight_ahead():
    poses = way(sets_off, none, 4 * SECOND)
    lines, published = run(poses, 0 * poses)
    driven, turned, told, told_turn = ahead_of(lines)
    assert driven > 0.15
    assert (told, told_turn) == (0, 0)
    assert abs(turned) <= 1
    assert published == len(BALLS)


@pytest.mark.slow
def test_odometry_that_dies_while_the_robot_drives_straight_ahead_is_told():
    poses = way(lambda t: 0.3, none, 5 * SECOND)
    dies = np.minimum(np.arange(len(poses)), 3 * SECOND)
    lines, _ = run(poses, poses[dies])
    driven, _, told, _ = ahead_of(lines)
    assert driven > told + 0.1


@pytest.mark.slow
@pytest.mark.parametrize(('speed', 'turn'), [(sets_off, none), (none, sets_off)])
def test_wheels_that_slip_before_a_picture_that_stands_are_told(speed, turn):
    pictures = 4 * SECOND
    lines, _ = run(way(none, none, pictures), way(speed, turn, pictures))
    driven, turned, told, told_turn = ahead_of(lines)
    assert abs(driven) < 0.1
    assert abs(turned) < 3
    assert max(told, np.radians(told_turn)) > 0.15


@pytest.mark.slow
@pytest.mark.parametrize('turn', [none, lambda t: 0.5 * np.cos(2 * t)])
@pytest.mark.parametrize('speed', [none, sets_off])
def test_odometry_that_is_right_is_not_told(speed, turn):
    poses = way(speed, turn, 4 * SECOND)
    assert run(poses, poses)[0] == []


@pytest.mark.slow
@pytest.mark.parametrize('speed', [none, sets_off])
@pytest.mark.parametrize('others', [0.0, 0.2])
def test_one_that_sets_off_beside_others_is_not_told(speed, others):
    """The others stand, or roll all the time."""

    def balls(t):
        ways = np.array([max(t - 1.5, 0), others * t, others * t])
        return BALLS + ways[:, None] * [0.3, 0.1, 0]

    poses = way(speed, none, 4 * SECOND)
    assert run(poses, poses, balls)[0] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ('speed', 'velocity'),
    [(none, (0.3, 0.0)), (sets_off, (0.25, 0.2)), (none, (0.0, -0.2)), (sets_off, (0.0, -0.2))],
)
def test_what_rolls_alike_is_no_mistake_while_all_drive_straight(speed, velocity):
    """By a yaw of the camera that is off, it would stand before a robot that drives."""
    poses = way(speed, none, 9 * SECOND)
    lines, published = run(poses, poses, lambda t: BALLS + t * np.array([*velocity, 0.0]))
    assert lines == []
    assert published == len(BALLS)


WRONG = {
    'the yaw of odometry has the wrong sign, and not its y': lambda x, y, yaw: (x, y, -yaw),
    'the y of odometry has the wrong sign, and not its yaw': lambda x, y, yaw: (x, -y, yaw),
    'x and y of odometry are exchanged, and its yaw is not': lambda x, y, yaw: (y, x, yaw),
    'odometry turns right where the robot turns left': lambda x, y, yaw: (x, -y, -yaw),
    'the yaw of odometry is off by pi/2': lambda x, y, yaw: (x, y, yaw + np.pi / 2),
    'the yaw of odometry is off by -pi/2': lambda x, y, yaw: (x, y, yaw - np.pi / 2),
}


def swings(t):
    return 0.5 * np.cos(2 * t)


@pytest.mark.slow
@pytest.mark.parametrize('line', WRONG)
def test_axes_that_are_swapped_are_named_and_nothing_is_published(line):
    poses = way(lambda t: 0.35, swings, 6 * SECOND)
    lines, published = run(poses, [WRONG[line](*pose) for pose in poses])
    assert published == 0
    assert line in lines[-1]


@pytest.mark.slow
@pytest.mark.parametrize('share', [0.8, 1.25])
def test_turns_by_another_track_are_named_with_the_amount(share):
    poses = way(lambda t: 0.3, swings, 6 * SECOND)
    told = way(lambda t: 0.3, lambda t: share * swings(t), 6 * SECOND)
    lines, published = run(poses, told)
    assert published == 0
    about, amount = lines[-1].split(' is off by about ')
    assert about.endswith('the turns that odometry tells')
    assert float(amount.split()[0]) == pytest.approx(100 * (share - 1), abs=5)
