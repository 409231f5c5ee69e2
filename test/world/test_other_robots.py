"""Cameras that are not on a robot with wheels: on a drone, on a ceiling, on a pan-tilt."""

import sys

import numpy as np
import pytest
from support.balls_seen import RADIUS
from support.balls_seen import seen
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

from world import CAMERA

from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.view import View

FRAME = 33_333_333
STILL = Pose.of_rpy((0, 0, 0), (0, 0, 0))


def locator(method, motion='plane', wander=0.5, **changes):
    told, kind = [], Kind('red', KindConfig(diameter=2 * RADIUS, motion=motion, wander=wander))
    return Locator(LocatorConfig(method=method, colors=(kind,), **changes), told.append), told


def ceiling(roll=0.0):
    """2.5 m above the ground, straight down."""
    return Pose.of_rpy((1, 2, 2.5), (roll, np.pi / 2, 0))


@pytest.mark.parametrize('method', ['ground', 'size', 'fused'])
def test_a_camera_on_the_ceiling_that_looks_straight_down_locates_what_rolls(method):
    one, told = locator(method)
    for k in range(60):
        ball = (1.3 - 0.3 * k / 30, 2.4, RADIUS)
        view = View(CAMERA, STILL, ceiling())
        (row,) = one.update(*seen(view, ball, (k + 1) * FRAME), view).rows
    assert (row['x'], row['y'], row['z']) == pytest.approx(ball, abs=0.03)
    assert (row['vx'], row['vy']) == pytest.approx((-0.3, 0), abs=0.05)
    assert told == []


@pytest.mark.parametrize('axis', [0, 1])
def test_a_camera_that_looks_down_may_lean_to_either_side(axis):
    """By 0.02 rad: from 2.4 m that is 5 cm, and the covariance says so on both axes."""
    one, _ = locator('ground', camera_pose_sigma=(0, 0, 0, 0.02, 0.02, 0.02))
    view = View(CAMERA, STILL, ceiling())
    (row,) = one.update(*seen(view, (1, 2, RADIUS), FRAME), view).rows
    assert np.sqrt(row['covariance'][axis, axis]) == pytest.approx(2.4 * 0.02, rel=0.1)


def drone(k):
    """Leans to where it flies, and sways."""
    t = k / 30
    return Pose.of_rpy(
        (0.5 * t, 0.1 * np.sin(t), 2 + 0.2 * np.sin(2 * t)),
        (0.15 * np.sin(3 * t), 0.1 * np.cos(2 * t), 0.2 * np.sin(t)),
    )


FORWARD = Pose.of_rpy((0.1, 0, -0.03), (0, 0, 0))


@pytest.mark.slow
def test_a_drone_sees_by_size_where_another_one_stands_in_the_air():
    one, told = locator('size', 'free')
    for k in range(90):
        view = View(CAMERA, drone(k), FORWARD)
        (row,) = one.update(*seen(view, (4, 0.3, 2.2), (k + 1) * FRAME), view).rows
    assert (row['x'], row['y'], row['z']) == pytest.approx((4, 0.3, 2.2), abs=0.1)
    assert np.linalg.norm([row['vx'], row['vy'], row['vz']]) < 0.1
    assert told == []


@pytest.mark.slow
def test_what_climbs_is_followed_and_not_told_to_be_off_the_ground():
    one, told = locator('size', 'free')
    for k in range(90):
        view, ball = View(CAMERA, drone(k), FORWARD), (4.5, 0.3, 1.8 + 0.3 * k / 30)
        (row,) = one.update(*seen(view, ball, (k + 1) * FRAME), view).rows
    assert row['z'] == pytest.approx(ball[2], abs=0.05)
    assert row['vz'] == pytest.approx(0.3, abs=0.1)
    assert told == []


def test_a_free_motion_needs_the_diameter_where_the_ground_does_not_tell():
    with pytest.raises(ValueError, match=r'red\.diameter: expected the diameter'):
        LocatorConfig(colors=(Kind('red', KindConfig(motion='free')),))


@pytest.mark.slow
@pytest.mark.parametrize('method', ['ground', 'size', 'fused'])
def test_a_camera_on_a_pan_tilt_sees_things_stand_while_it_turns(method):
    one, told = locator(method)
    for k in range(90):
        mount = Pose.of_rpy((0.1, 0, 0.6), (0, 0.25 + 0.1 * np.sin(k / 9), 0.4 * np.sin(k / 12)))
        view = View(CAMERA, STILL, mount)
        (row,) = one.update(*seen(view, (3, 0.2, RADIUS), (k + 1) * FRAME), view).rows
        assert (row['x'], row['y'], row['z']) == pytest.approx((3, 0.2, RADIUS), abs=0.04)
    assert np.hypot(row['vx'], row['vy']) < 0.02
    assert told == []


@pytest.mark.parametrize('pitch', [0.0, 0.01])
def test_what_falls_is_located_beside_what_shows_the_pitch_on_the_ground(pitch):
    """The robot drives for 2 s, and finds out its pitch by what rolls and stands."""
    told, of = [], {'diameter': 2 * RADIUS, 'motion': 'free_fall'}
    kinds = (Kind('red', KindConfig(diameter=2 * RADIUS)), Kind('green', KindConfig(**of)))
    one = Locator(LocatorConfig(colors=kinds), told.append)
    mount, given = (Pose.of_rpy((0.1, 0, 0.5), (0, 0.25 + p, 0)) for p in (pitch, 0))
    for k in range(60):
        t = k / 30
        base, away = Pose.of_rpy((0.5 * t, 0, 0), (0, 0, 0)), t % 0.5
        flying = (4, 0.8, 0.3 + 2.45 * away - 9.80665 / 2 * away**2)
        balls = [(3, 0.2, RADIUS), (4, -0.5, RADIUS), flying]
        tracks, detections = seen(View(CAMERA, base, mount), balls, (k + 1) * FRAME)
        tracks.rows['color'][2] = detections.rows['color'][0] = 1
        rows = one.update(tracks, detections, View(CAMERA, base, given)).rows
        assert np.isfinite(rows['covariance']).all()
    for row, ball in zip(rows, balls, strict=True):
        assert (row['x'], row['y']) == pytest.approx(ball[:2], abs=0.1)
    assert told == []


def climbing(k):
    """Climbs, rolls and pitches by 20 degrees."""
    t = k / 30
    lean = 0.35 * np.sin(1.1 * t), 0.35 * np.sin(0.8 * t + 1)
    return Pose.of_rpy((-1 + 0.5 * t, 0.3 * np.sin(0.5 * t), 1.5 + 0.25 * t), (*lean, 0.1))


@pytest.mark.parametrize('method', ['ground', 'size', 'fused'])
def test_a_drone_that_climbs_and_leans_sees_on_the_ground_what_stands_there(method):
    """Its camera looks down by 45 degrees."""
    one, told = locator(method)
    for k in range(90):
        view = View(CAMERA, climbing(k), Pose.of_rpy((0.1, 0, -0.05), (0, np.pi / 4, 0)))
        tracks, detections = seen(view, (2, 0.3, RADIUS), (k + 1) * FRAME)
        high = detections.rows['box_v'] + detections.rows['box_h']
        if detections.rows['box_v'][0] < 1 or high[0] > CAMERA.height - 1:
            continue  # it leans so far that the ball is not in the picture
        (row,) = one.update(tracks, detections, view).rows
        assert (row['x'], row['y'], row['z']) == pytest.approx((2, 0.3, RADIUS), abs=0.03)
    assert np.hypot(row['vx'], row['vy']) < 0.02
    assert told == []


@pytest.mark.slow
@pytest.mark.parametrize('method', ['ground', 'size', 'fused'])
def test_to_stand_still_for_a_long_time_makes_nothing_more_certain(method):
    """For 2 minutes, at 2 Hz; the pitch stays what it was said to be."""
    one, told = locator(method)
    view, spreads = View(CAMERA, STILL, Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0))), []
    for k in range(240):
        found = one.update(*seen(view, (3, 0.2, RADIUS), round((k + 1) * 5e8)), view)
        (row,) = found.rows
        spreads.append(np.sqrt(np.trace(row['covariance'].reshape(6, 6)[:3, :3])))
    assert (row['x'], row['y'], row['z']) == pytest.approx((3, 0.2, RADIUS), abs=0.03)
    assert 0.85 * spreads[5] < spreads[-1] < 1.5 * spreads[5]
    assert told == []


def test_above_the_horizon_the_ground_tells_nothing_and_size_what_is_there():
    view = View(CAMERA, STILL, Pose.of_rpy((0.1, 0, 0.5), (0, -0.3, 0)))
    one, told = locator('ground')
    assert len(one.update(*seen(view, (4, 0.3, 1.6), FRAME), view).rows) == 0
    assert 'does not meet the ground' in told[0]
    one, told = locator('size', 'free')
    for k in range(30):
        (row,) = one.update(*seen(view, (4, 0.3, 1.6), (k + 1) * FRAME), view).rows
    assert (row['x'], row['y'], row['z']) == pytest.approx((4, 0.3, 1.6), abs=0.03)
    assert told == []


def test_far_from_the_origin_of_the_frame_what_is_rounded_is_told_and_in_the_covariance():
    """As in UTM: FLOAT32 numbers near 4 600 000 are 0.5 apart."""
    one, told = locator('size')
    base = Pose.of_rpy((500_000, 4_600_000, 0), (0, 0, 0))
    view = View(CAMERA, base, Pose.of_rpy((0, 0, 0.5), (0, 0.2, 0)))
    (row,) = one.update(*seen(view, (500_002, 4_600_000.2, RADIUS), FRAME), view).rows
    assert 'rounded to 0.5 m' in told[0]
    assert row['covariance'][1, 1] > 0.5**2 / 12
    assert abs(row['y'] - 4_600_000.2) < 3 * np.sqrt(row['covariance'][1, 1])


def rolling(one, ys):
    """The last row of a ball that rolls across, at 3 m."""
    view = View(CAMERA, STILL, Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0)))
    for k, y in enumerate(ys):
        (row,) = one.update(*seen(view, (3, y, RADIUS), (k + 1) * FRAME), view).rows
    return row


def test_what_bounces_off_a_wall_is_followed_at_once():
    one, told = locator('ground', wander=0.1)
    there = np.arange(45) * 1.5 / 30 - 1.1
    row = rolling(one, [*there, *there[::-1][1:7]])
    assert row['y'] / row['x'] == pytest.approx(there[-7] / 3, abs=0.005)
    assert row['vy'] == pytest.approx(-1.5, abs=0.3)
    assert row['time_since_update'] == 0
    assert told == []


def test_one_picture_in_which_something_else_is_taken_for_it_is_no_bounce():
    one, told = locator('ground', wander=0.1)
    there = np.arange(45) * 1.5 / 30 - 1.1
    row = rolling(one, [*there[:-1], there[-1] - 0.15])
    assert row['vy'] == pytest.approx(1.5, abs=0.2)
    assert row['y'] / row['x'] == pytest.approx(there[-1] / 3, abs=0.005)
    assert told == []
