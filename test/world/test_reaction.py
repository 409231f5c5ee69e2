"""A robot that does late what it is told follows well once that is said, and is told of before."""

from collections import deque
import math

import numpy as np
import pytest
from support.around_corners import around_corners
from support.around_corners import SECOND
from support.around_corners import see_late
from support.around_corners import TICK

from colortrack_ros.simulation.robot import Place
from colortrack_ros.world.following import Following
from colortrack_ros.world.following import FollowingConfig
from colortrack_ros.world.following import Target
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.reaction import Commands


def follow(target_at, seconds, dead=0.5, lag=0.3, seen=lambda t: True, scale=1.0, **config):
    """Drive after a target with a dead time and a lag [s]; time, speed, turn, range, bearing of
    each tick, and what is told of the robot.

    :param scale: of the turns that the robot makes to those that it is told.
    """
    following, place, speeds = Following(FollowingConfig(**config)), Place(), np.zeros(2)
    told, waiting, log, lines = deque([np.zeros(2)] * round(dead * SECOND / TICK)), [], [], set()
    for now in range(0, round(seconds * SECOND), TICK):
        where = see_late(following, waiting, target_at, now, seen)
        told.append(np.array(following.step(now, place.pose, now)))
        share = 1 - math.exp(-TICK / SECOND / lag) if lag else 1.0
        speeds = speeds + share * (told.popleft() * (1.0, scale) - speeds)
        place = place.moved(*(speeds * TICK / SECOND))
        away = where - (place.x, place.y)
        bearing = math.remainder(math.atan2(away[1], away[0]) - place.yaw, 2 * math.pi)
        log.append((now / SECOND, *speeds, math.hypot(*away), bearing))
        lines.add(following.turns.line)
    return np.array(log), ''.join(lines)


def stands(t):
    return 3.0, 1.5


@pytest.mark.slow
@pytest.mark.parametrize(('dead', 'lag'), [(0.2, 0.2), (0.5, 0.0), (0.5, 0.3), (0.8, 0.3)])
def test_a_late_robot_that_is_said_to_be_stands_still_before_what_stands(dead, lag):
    """Not so if nothing is said: it swung by 0.4 to 1.4 rad for good if it was late by 0.5 s."""
    late = {'reaction': dead + lag, 'stop_within': dead + lag + 0.4}
    log, line = follow(stands, 20.0, dead, lag, **late)
    last = log[log[:, 0] > 15]
    assert np.abs(last[:, 1:3]).max() < 0.01
    assert np.abs(last[:, 4]).max() < 0.01
    assert last[:, 3] == pytest.approx(1.0, abs=0.05)
    assert line == ''


@pytest.mark.slow
def test_around_corners_it_looks_at_its_target_and_keeps_its_distance():
    log, _ = follow(around_corners, 30.0, reaction=0.8, stop_within=1.2)
    settled = log[log[:, 0] > 8]
    assert np.abs(settled[:, 4]).max() < 0.4
    assert np.abs(settled[:, 3] - 1.0).max() < 0.4


@pytest.mark.slow
@pytest.mark.parametrize(
    ('dead', 'lag', 'least', 'most'), [(0.5, 0.0, 0.4, 0.6), (0.5, 0.3, 0.7, 0.9)]
)
def test_a_late_robot_is_told_of_with_the_time(dead, lag, least, most):
    _, line = follow(stands, 8.0, dead, lag)
    assert line.startswith('the robot turns ')
    assert least <= float(line.split()[3]) <= most
    assert 'set reaction to that, which is 0 s' in line


@pytest.mark.slow
@pytest.mark.parametrize(
    ('dead', 'lag', 'scale'), [(0.0, 0.0, 1.0), (0.1, 0.1, 1.0), (0.04, 0.0, 0.7)]
)
@pytest.mark.parametrize('target', [stands, around_corners])
def test_a_robot_that_is_not_late_is_not_told_of(target, dead, lag, scale):
    assert follow(target, 20.0, dead, lag, scale=scale)[1] == ''


@pytest.mark.slow
@pytest.mark.parametrize(('angle', 'rate'), [(0.2, 0.9), (0.5, 1.6), (0.7, 1.3)])
def test_a_robot_that_somebody_else_turns_is_not_late(angle, rate):
    """By a joystick, say: commands to look at the target come before each turn, or after it."""
    following, lines = Following(FollowingConfig()), set()
    for now in range(0, 20 * SECOND, TICK):
        pose = Pose.of_rpy((0, 0, 0), (0, 0, angle * math.sin(rate * now / SECOND)))
        following.see(Target(np.array([3.0, 0.4]), np.zeros(2), now, now))
        following.step(now, pose, now)
        lines.add(following.turns.line)
    assert lines == {''}


def test_it_stands_in_time_after_its_target_was_last_seen_since_it_is_told_earlier():
    log, _ = follow(
        lambda t: (1.2 + 0.3 * t, 0.0),
        8.0,
        0.3,
        0.0,
        lambda t: t < 5,
        reaction=0.3,
        stop_within=0.8,
    )
    driving = log[(log[:, 0] > 4) & (log[:, 0] < 5)]
    assert driving[:, 1].min() > 0.25
    assert np.abs(log[log[:, 0] >= 5.8][:, 1:3]).max() == pytest.approx(0.0, abs=0.01)


def test_a_robot_that_is_too_late_to_stand_in_time_is_refused():
    with pytest.raises(ValueError, match=r'stop_within: expected more than 0\.55 s'):
        FollowingConfig(reaction=0.5)


def test_what_was_told_while_a_time_is_carried_out_and_nothing_else():
    commands = Commands()
    for now, speed, turn in ((0, 1.0, 0.0), (1, 0.0, math.pi / 2), (2, 0.5, 0.0)):
        commands.give(now * SECOND, speed, turn)
    start = Pose.of_rpy((1.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    there, heading = commands.carried_out(start, SECOND // 2, 4 * SECOND)
    assert there == pytest.approx([1.5, 1.0])
    assert heading == pytest.approx(math.pi / 2)
    assert commands.turned(np.array([-1.0, 0.5, 1.5, 3.0])) == pytest.approx(
        [0.0, 0.0, math.pi / 4, math.pi / 2]
    )
    commands.give(0, 0.0, 0.0)  # time has gone back
    assert commands.carried_out(start, 0, SECOND)[1] == 0.0
    assert Commands().carried_out(start, 0, SECOND)[1] == 0.0


def test_commands_are_kept_for_seconds_not_for_good():
    commands = Commands()
    for now in range(0, 100 * SECOND, TICK):
        commands.give(now, 0.1, 0.0)
    assert len(commands._given) < 10 * SECOND / TICK
