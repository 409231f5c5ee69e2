"""Odometry whose poses contradict its twists is told; what robots really send is not."""

import numpy as np
import pytest

from colortrack_ros.world import Pose
from colortrack_ros.world.twists import Twists

STEP = 50_000_000


def lines(poses, velocity, turn, step=STEP):
    """What is told of poses x, y, yaw and constant twists."""
    twists = Twists()
    each = (
        twists.see(k * step, Pose.of_rpy((x, y, 0), (0, 0, yaw)), velocity, turn)
        for k, (x, y, yaw) in enumerate(poses)
    )
    return [line for line in each if line]


def arc(speed, turn, seconds=2.0, sideways=0.0):
    """Poses, (N, 3), of a robot."""
    yaw = turn * STEP / 1e9 * np.arange(round(seconds * 1e9 / STEP))
    steps = (speed + 1j * sideways) * STEP / 1e9 * np.exp(1j * yaw)
    at = np.cumsum(steps) - steps
    return np.stack([at.real, at.imag, yaw], axis=1)


def test_a_last_message_that_is_repeated_is_told_within_a_second():
    repeated = np.concatenate([arc(0.4, 0.2), np.tile(arc(0.4, 0.2)[-1], (25, 1))])
    found = lines(repeated, (0.4, 0.0), 0.2)
    assert 'its pose stands while its twist drives 0.40 m' in found[0]
    assert not lines(np.zeros((60, 3)), (0.0, 0.0), 0.0)


def test_a_yaw_with_the_wrong_sign_is_told():
    poses = arc(0.0, 0.5)
    assert 'its yaw has the wrong sign' in lines(poses * [1, 1, -1], (0.0, 0.0), 0.5)[0]


@pytest.mark.parametrize('change', ['exchanged', 'backward', 'frame'])
def test_axes_that_do_not_belong_together_are_told(change):
    poses = arc(0.4, 0.0)
    changed = {
        'exchanged': poses[:, [1, 0, 2]], 'backward': poses * [-1, -1, 1],
        'frame': poses + np.array([0, 0, np.pi / 2]),
    }[change]  # fmt: skip
    # the twist is in the frame of the robot, and in the fixed one here
    assert ('axes are exchanged' in (lines(changed, (0.4, 0.0), 0.0) or [''])[0]) == (
        change != 'frame'
    )


@pytest.mark.parametrize(
    ('speed', 'turn', 'sideways'),
    [(0.4, 0.0, 0.0), (0.4, 1.0, 0.0), (-0.3, 0.4, 0.0), (0.2, 0.0, 0.3), (0.0, 1.5, 0.0)],
)
def test_what_robots_drive_is_not_told(speed, turn, sideways):
    poses = arc(speed, turn, sideways=sideways)
    assert not lines(poses, (speed, sideways), turn)
    assert not lines(poses, (1.25 * speed, 1.25 * sideways), 0.8 * turn)
    assert not lines(poses, (0.0, 0.0), 0.0)  # twists that are not filled in
    assert not lines(poses, (np.nan, 0.0), turn)
    assert not lines(poses, (speed, sideways), turn, step=STEP * 20)  # once a second


@pytest.mark.parametrize('behind', [True, False])
def test_a_robot_that_stops_in_a_gap_between_messages_is_not_told(behind):
    """A driver that differentiates its poses tells the twist of the way behind."""
    twists, steps = Twists(), [0.05] * 20 + [0.45] + [0.05] * 20
    stamps = np.cumsum([0.0, *steps])
    rates = np.array([1.5] * 20 + [0.0] * 21)
    yaw = np.cumsum([0.0, *rates * steps])
    told = [0.0, *rates] if behind else [*rates, 0.0]
    for stamp, at, turn in zip(stamps, yaw, told, strict=True):
        pose = Pose.of_rpy((0, 0, 0), (0, 0, at))
        assert not twists.see(round(stamp * 1e9), pose, (0.0, 0.0), turn)


def test_twists_in_the_fixed_frame_are_not_told():
    poses = arc(0.4, 0.0) @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]) + [0, 0, np.pi / 2]
    assert not lines(poses, (0.0, 0.4), 0.0)


def test_odometry_that_is_reset_or_goes_back_starts_anew():
    twists = Twists()
    for stamp in (*range(0, 10), 3, *range(4, 12)):
        assert not twists.see(stamp * 100_000_000, Pose(np.zeros(3), np.eye(3)), (0.4, 0), 0.0) or (
            stamp > 9
        )
