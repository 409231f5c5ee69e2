"""A robot follows at its distance, and never drives after what it does not see."""

import math

import numpy as np
import pytest
from support.around_corners import around_corners
from support.around_corners import SECOND
from support.around_corners import see_late
from support.around_corners import TICK

from colortrack_ros.simulation.robot import Robot
from colortrack_ros.world.following import Following
from colortrack_ros.world.following import FollowingConfig
from colortrack_ros.world.following import Target
from colortrack_ros.world.poses import Pose

ORIGIN = Pose.of_rpy((0, 0, 0), (0, 0, 0))


def ahead(x, y=0.0, velocity=(0.0, 0.0), stamp=0, **more):
    return Target(np.array([x, y]), np.array(velocity), stamp, more.pop('measured', stamp), **more)


def follow(target_at, seconds, config=None, seen=lambda t: True):
    """Drive a robot after a target; (time, speed, turn, range, bearing) of each tick."""
    robot = Robot((0.0, 0.0), np.random.default_rng(0))
    following, log, waiting = Following(config or FollowingConfig()), [], []
    for now in range(0, round(seconds * SECOND), TICK):
        place = see_late(following, waiting, target_at, now, seen)
        speeds = following.step(now, robot.place.pose, now)
        robot.command(*speeds)
        robot.go(robot.next(TICK / SECOND), TICK / SECOND)
        away = place - (robot.place.x, robot.place.y)
        bearing = math.remainder(math.atan2(away[1], away[0]) - robot.place.yaw, 2 * math.pi)
        log.append((now / SECOND, robot.speed, robot.turn, math.hypot(*away), bearing))
    return np.array(log)


def test_it_keeps_its_distance_to_a_target_that_goes_around_corners():
    log = follow(around_corners, 40.0)
    settled = log[log[:, 0] > 5]
    assert np.abs(settled[:, 3] - 1.0).max() < 0.2
    assert np.abs(settled[:, 4]).max() < 0.5


def test_speeds_and_their_changes_stay_within_the_limits():
    config = FollowingConfig(max_speed=0.5, max_turn=1.0)
    log = follow(lambda t: (4.0, 3.0) if t < 4 else (-3.0, 1.0), 12.0, config)
    assert 0 <= log[:, 1].min() <= log[:, 1].max() <= 0.5 + 1e-9
    assert np.abs(log[:, 2]).max() <= 1.0 + 1e-9
    assert np.diff(log[:, 1]).max() <= 1.0 * TICK / SECOND + 1e-9


def test_it_stands_within_the_time_after_the_target_was_last_seen_and_brakes_smoothly():
    log = follow(lambda t: (1.2 + 0.4 * t, 0.0), 8.0, seen=lambda t: t < 5.0)
    driving = log[(log[:, 0] > 4) & (log[:, 0] < 5)]
    assert driving[:, 1].min() > 0.35
    assert np.abs(log[log[:, 0] >= 5.3][:, 1:3]).max() == pytest.approx(0.0, abs=0.01)
    assert np.diff(log[:, 1]).min() >= -3.1 * TICK / SECOND


def test_it_goes_on_when_the_target_is_seen_again():
    log = follow(lambda t: (3.0, 0.5), 12.0, seen=lambda t: not 1.0 < t < 3.0)
    assert log[-1, 3] == pytest.approx(1.0, abs=0.1)


def test_it_does_not_drive_backwards_unless_asked():
    assert follow(lambda t: (0.4, 0.0), 3.0)[:, 1].min() == 0.0
    log = follow(lambda t: (0.4, 0.0), 8.0, FollowingConfig(backwards=True))
    assert log[-1, 3] == pytest.approx(1.0, abs=0.1)


def test_it_turns_to_a_target_behind_it_before_it_drives():
    log = follow(lambda t: (-3.0, 0.1), 10.0)
    assert log[np.abs(log[:, 4]) > 1.6][:, 1].max() == 0.0
    assert log[-1, 3] == pytest.approx(1.0, abs=0.1)


def stepped(following, now, at=None, ticks=20):
    """Speeds after some ticks up to now, odometry being of `at`."""
    for k in range(ticks, -1, -1):
        moment = now - k * TICK
        speeds = following.step(moment, ORIGIN, moment if at is None else at)
    return speeds


def test_what_coasts_or_is_uncertain_counts_as_not_measured():
    now = 10 * SECOND
    for target in (ahead(3.0, stamp=now, measured=now - SECOND), ahead(3.0, stamp=now, sigma=0.6)):
        following = Following(FollowingConfig())
        following.see(target)
        assert stepped(following, now) == (0.0, 0.0)
        assert not following.follows
    following.see(ahead(3.0, stamp=now, sigma=0.4))
    assert stepped(following, now)[0] > 0.1


@pytest.mark.parametrize(('late', 'told'), [(0.24, 'drives at 0.03 m/s at most'), (0.1, '')])
def test_a_robot_that_may_not_drive_since_its_target_is_measured_late_is_told_of(late, told):
    """It follows, but creeps: by stop_within, 0.3 s, it has to stand again."""
    following, speeds = Following(FollowingConfig()), []
    for now in range(SECOND, 5 * SECOND, 50_000_000):
        following.see(ahead(9.0, stamp=now - round(late * SECOND)))
        speeds.append(following.step(now, ORIGIN, now)[0])
        if now < 2.9 * SECOND:
            assert following.slow == ''
    assert following.follows
    assert (max(speeds) < 0.1) == bool(told)
    assert told in following.slow
    assert bool(told) == bool(following.slow)
    following.lose('the clock stands')
    following.step(6 * SECOND, ORIGIN, 6 * SECOND)
    assert following.slow == ''


def test_odometry_that_stops_stops_the_robot_and_is_named():
    following, now = Following(FollowingConfig()), 10 * SECOND
    following.see(ahead(3.0, stamp=now))
    assert stepped(following, now, at=now - SECOND) == (0.0, 0.0)
    assert following.state == 'the odometry is 1.0 s old'


def test_a_clock_that_goes_back_stops_the_robot():
    following, now = Following(FollowingConfig()), 10 * SECOND
    following.see(ahead(3.0, stamp=now))
    assert stepped(following, now)[0] > 0
    assert stepped(following, now - 5 * SECOND) == (0.0, 0.0)
    assert 'clock has gone back' in following.state


def test_stop_is_at_once_and_holds_until_told_to_go():
    following, now = Following(FollowingConfig()), 10 * SECOND
    following.see(ahead(3.0, stamp=now))
    assert stepped(following, now)[0] > 0.1
    following.stop()
    assert following.step(now, ORIGIN, now) == (0.0, 0.0)
    assert stepped(following, now) == (0.0, 0.0)
    following.go()
    assert stepped(following, now)[0] > 0.1


def test_a_robot_that_was_made_to_stand_for_a_while_starts_slowly():
    """It went on at the speed of before at once, turned as it was told to long ago."""
    following, now = Following(FollowingConfig(reaction=0.8, stop_within=1.2)), 0
    for now in range(0, 2 * SECOND, TICK):
        following.see(ahead(3.0, 3.0, stamp=now))
        before = following.step(now, ORIGIN, now)
    assert before[0] > 0.4
    assert before[1] > 0.4
    following.commands.give(now, 0.0, 0.0)
    for now in range(12 * SECOND, 12 * SECOND + 10 * TICK, TICK):
        following.see(ahead(3.0, stamp=now))
        speed, turn = following.step(now, ORIGIN, now)
        assert speed <= (now - 12 * SECOND) / SECOND + 1e-9
        assert turn == 0


def test_odometry_that_jumps_loses_the_target_until_it_is_measured_in_the_new_frame():
    """Where it was is elsewhere then: the robot would turn and drive to it."""
    following, elsewhere = Following(FollowingConfig()), Pose.of_rpy((5, 2, 0), (0, 0, 3))
    for now in range(0, SECOND, TICK):
        following.see(ahead(3.0, stamp=now))
        speed, _ = following.step(now, ORIGIN, now)
    assert speed > 0.5
    jump = now + TICK
    following.see(ahead(3.0, stamp=now))
    assert following.step(jump, elsewhere, jump) == (0, 0)
    assert 'the robot has jumped by 5.39 m' in following.state
    following.see(ahead(3.0, stamp=now))
    assert following.step(jump + TICK, elsewhere, jump + TICK) == (0, 0)
    following.see(ahead(2.0, 2.5, stamp=jump + TICK))
    assert following.step(jump + 2 * TICK, elsewhere, jump + 2 * TICK)[0] > 0
    assert following.follows


@pytest.mark.parametrize('place', [(-3.0, 1.0), (0.5, 0.0), (0.0, 0.0), (1e30, -1e30)])
def test_a_target_that_jumps_anywhere_is_turned_to_within_all_limits(place):
    following, last, config = Following(FollowingConfig()), (0.0, 0.0), FollowingConfig()
    for now in range(0, 2 * SECOND, TICK):
        following.see(ahead(*(place if now > SECOND else (3.0, 0.0)), stamp=now))
        speeds = following.step(now, ORIGIN, now)
        assert np.isfinite(speeds).all()
        assert 0 <= speeds[0] <= config.max_speed
        assert abs(speeds[1]) <= config.max_turn
        assert last[0] - speeds[0] <= config.braking * TICK / SECOND + 1e-9
        last = speeds
    assert speeds[0] == 0 or place[0] == 1e30
