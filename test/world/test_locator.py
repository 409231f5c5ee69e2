import sys

import numpy as np
import pytest
from scipy.special import chdtri
from support.balls_seen import FRAME
from support.balls_seen import RADIUS
from support.balls_seen import seen
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

from world import CAMERA
from world import MOUNT

from colortrack_ros.data import Detections
from colortrack_ros.data import Tracks
from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.view import View


def locator(method='ground', **changes):
    kind = Kind('red', KindConfig(**{'diameter': 2 * RADIUS} | changes))
    told = []
    return Locator(LocatorConfig(method=method, colors=(kind,)), told.append), told


def view_at(x=0.0, yaw=0.0, mount=MOUNT):
    return View(CAMERA, Pose.of_rpy((x, 0, 0), (0, 0, yaw)), mount)


def depth_of(view, point):
    """A depth picture of a ball before a wall at 8 m, every third pixel a hole."""
    v, u = np.mgrid[0:480, 0:640]
    rays = view.camera.rays(np.stack([u.ravel(), v.ravel()], axis=1).astype(float))
    q = view.optical.inverse().apply(np.array([point]))[0]
    along = rays @ q
    inside = along**2 - (q @ q - RADIUS**2)
    hit = (along - np.sqrt(np.maximum(inside, 0))) * rays[:, 2]
    depth = np.where(inside > 0, hit, 8.0).reshape(480, 640).astype(np.float32)
    depth[:, ::3] = np.nan
    return depth


BALL = (3.0, 0.4, RADIUS)


@pytest.mark.slow
@pytest.mark.parametrize('method', ['ground', 'size', 'depth', 'fused'])
def test_a_ball_is_located_by_each_method(method):
    one, told = locator(method)
    view = view_at()
    depth = depth_of(view, BALL)
    for k in range(10):
        out = one.update(*seen(view, BALL, (k + 1) * FRAME), view, depth)
    (row,) = out.rows
    assert (row['x'], row['y'], row['z']) == pytest.approx(BALL, abs=0.03)
    assert row['track_id'] == 1
    assert row['diameter'] == pytest.approx(0.2)
    assert row['time_since_update'] == 0
    assert np.linalg.eigvalsh(row['covariance']).min() > -1e-12
    assert told == []


def test_a_ball_that_stands_stays_where_it_is_while_the_robot_drives_and_turns():
    one, told = locator()
    for k in range(60):
        view = view_at(0.5 * k / 30, 0.3 * np.sin(k / 10))
        out = one.update(*seen(view, BALL, (k + 1) * FRAME), view)
    (row,) = out.rows
    assert (row['x'], row['y'], row['z']) == pytest.approx(BALL, abs=0.02)
    assert np.hypot(row['vx'], row['vy']) < 0.03
    assert told == []


def test_each_track_has_the_detection_that_it_took():
    one, _ = locator()
    balls = [(3, 0.4, RADIUS), (2, -0.5, RADIUS), (4, 0, RADIUS)]
    out = one.update(*seen(view_at(), balls, FRAME, ids=[3, 4, 9]), view_at())
    assert out.rows['track_id'].tolist() == [3, 4, 9]
    np.testing.assert_allclose(out.rows['x'], [3, 2, 4], atol=0.01)


def test_an_object_out_of_sight_coasts_and_is_gone_with_its_track():
    one, _ = locator()
    tracks, detections = seen(view_at(), BALL, FRAME)
    first = one.update(tracks, detections, view_at())
    tracks.rows['time_since_update'] = 0.5
    later = Tracks(tracks.rows, FRAME + 500_000_000)
    out = one.update(later, Detections(stamp=later.stamp), view_at(yaw=3.0))
    assert out.rows['time_since_update'][0] == pytest.approx(0.5)
    assert out.rows['covariance'][0, 0, 0] > first.rows['covariance'][0, 0, 0]
    assert len(one.update(Tracks(stamp=later.stamp + FRAME), Detections(), view_at()).rows) == 0


def row_of(one, place, k, last):
    """Return the row of a ball in picture k, which is out of sight after the last."""
    tracks, detections = seen(view_at(), place, k * FRAME)
    if k > last:
        tracks.rows['time_since_update'] = (k - last) / 30
        detections = Detections(stamp=tracks.stamp)
    (row,) = one.update(tracks, detections, view_at()).rows
    return row


def is_within(row, place):
    """Return whether a place is within the ellipse of 99.9 %."""
    off = np.array([row['x'], row['y'], row['z']]) - place
    return off @ np.linalg.solve(row['covariance'][:3, :3], off) < chdtri(3, 0.001)


@pytest.mark.parametrize('method', ['ground', 'size'])
def test_a_ball_that_hits_a_wall_behind_a_cover_comes_back_within_its_ellipse(method):
    one, told = locator(method, wander=0.05)
    y, speed = -1.0, 0.6
    for k in range(1, 61):
        speed = -0.7 * 0.6 if k > 40 else 0.6
        y += speed / 30
        row = row_of(one, (2.5, y, RADIUS), k, 30)
    assert is_within(row, (2.5, y, RADIUS))
    (row,) = one.update(*seen(view_at(), (2.5, y, RADIUS), 61 * FRAME), view_at()).rows
    assert (row['x'], row['y']) == pytest.approx((2.5, y), abs=0.05)
    assert told == []


@pytest.mark.parametrize('method', ['ground', 'size'])
def test_a_ball_that_sets_off_four_times_as_fast_as_told_is_followed_after_two_pictures(method):
    """Out of sight from then on, it is within its ellipse."""
    one, told = locator(method, speed=0.15, wander=0.1)
    for k in range(1, 21):
        y = 0.6 * max(k - 7, 0) / 30
        row = row_of(one, (2.2, y, RADIUS), k, 10)
    assert is_within(row, (2.2, y, RADIUS))
    assert told == []


def test_what_the_edge_of_the_picture_cuts_is_no_measurement():
    one, _ = locator()
    view = view_at()
    tracks, detections = seen(view, BALL, FRAME)
    detections.rows['box_u'] = 0
    assert len(one.update(tracks, detections, view).rows) == 0


def test_a_partly_hidden_ball_is_not_taken_for_a_smaller_one_farther_away():
    one, _ = locator('size')
    view = view_at()
    one.update(*seen(view, BALL, FRAME), view)
    tracks, detections = seen(view, BALL, 2 * FRAME)
    for rows in (tracks.rows, detections.rows):
        rows['box_w'] /= 2
        rows['area'] /= 2
    out = one.update(tracks, detections, view)
    assert out.rows['x'][0] == pytest.approx(3, abs=0.03)


def test_at_now_it_is_farther_along_and_less_certain():
    one, _ = locator()
    for k in range(30):
        ball = (3.0, 0.4 - 0.3 * k * FRAME / 1e9, RADIUS)
        out = one.update(*seen(view_at(), ball, (k + 1) * FRAME), view_at())
    ahead = one.locations(out.stamp + 200_000_000)
    assert ahead.stamp == out.stamp + 200_000_000
    assert ahead.rows['y'][0] - out.rows['y'][0] == pytest.approx(-0.06, abs=0.01)
    assert ahead.rows['covariance'][0, 1, 1] > out.rows['covariance'][0, 1, 1]
    again = one.locations(out.stamp)
    assert again.rows['y'][0] == out.rows['y'][0]


@pytest.mark.parametrize('pitch', [0.0, 0.25])
def test_an_upside_down_camera_is_told(pitch):
    right = Pose.of_rpy(MOUNT.t, (0, pitch, 0))
    wrong = Pose(MOUNT.t, right.R @ np.diag([1.0, -1, -1]))
    one, told = locator()
    balls = [(2, -0.4, RADIUS), (3, 0.4, RADIUS)]
    one.update(*seen(view_at(mount=right), balls, FRAME), view_at(mount=wrong))
    assert 'camera_pose' in told[0]


def test_a_wrong_diameter_is_told_where_the_ground_sees_it():
    one, told = locator(height=RADIUS, diameter=0.4)
    one.update(*seen(view_at(), BALL, FRAME), view_at())
    assert 'diameter is wrong' in told[0]


def test_a_wrong_height_of_the_camera_is_told_where_size_or_depth_see_it():
    one, told = locator('size')
    wrong = Pose(MOUNT.t + np.array([0, 0, 0.5]), MOUNT.R)
    one.update(*seen(view_at(), (2, 0, RADIUS), FRAME), view_at(mount=wrong))
    assert 'm off the height' in told[0]


@pytest.mark.parametrize(('share', 'least'), [(0.7, 0.8), (1.0, 0.0)])
def test_the_covariance_by_size_reaches_to_the_ground_where_size_and_ground_disagree(share, least):
    """A ball of 0.7 times the diameter of its color, and one that is as large as it is said to be.

    The former is located 0.8 m and more too far away; by its size alone 0.1 m would be expected.
    """
    one, _ = locator('size', diameter=2 * RADIUS / share, height=RADIUS)
    for k in range(10):
        (row,) = one.update(*seen(view_at(), BALL, (k + 1) * FRAME), view_at()).rows
    cov = row['covariance'].reshape(6, 6)[:3, :3]
    e = np.array([row[name] for name in 'xyz'], float) - BALL
    assert e @ np.linalg.solve(cov, e) < chdtri(3, 0.001)
    assert least <= np.linalg.norm(e) < least + 0.6
    assert np.sqrt(np.trace(cov)) < least + 1


def test_a_color_that_is_not_known_is_told():
    one, told = locator()
    tracks, detections = seen(view_at(), BALL, FRAME)
    tracks.rows['color'] = detections.rows['color'] = 3
    assert len(one.update(tracks, detections, view_at()).rows) == 0
    assert 'track of color 3' in told[0]


def test_a_clock_that_goes_back_starts_afresh_and_says_so():
    one, told = locator()
    one.update(*seen(view_at(), BALL, 100 * FRAME), view_at())
    out = one.update(*seen(view_at(), (2, 0, RADIUS), FRAME), view_at())
    assert out.rows['x'][0] == pytest.approx(2, abs=0.02)
    assert 'objects restart' in told[0]


def test_a_robot_that_jumps_is_told_and_its_objects_start_anew():
    one, told = locator()
    one.update(*seen(view_at(), BALL, FRAME), view_at())
    there = view_at(5.0)
    out = one.update(*seen(there, (8, 0.4, RADIUS), 2 * FRAME), there)
    assert out.rows['x'][0] == pytest.approx(8, abs=0.02)
    assert 'jumped by 5.00 m' in told[0]


def test_a_calibration_of_another_picture_size_is_told_and_locates_nothing():
    one, told = locator()
    tracks, detections = seen(view_at(), BALL, FRAME)
    detections.rows['u'] = tracks.rows['u'] = 900
    assert len(one.update(tracks, detections, view_at()).rows) == 0
    assert 'outside of the 640x480 picture of CameraInfo' in told[0]


def test_a_depth_picture_of_another_size_is_told_and_not_read():
    """As of a depth camera that is not aligned with the color: its pixels look elsewhere."""
    one, told = locator('depth')
    view = view_at()
    depth = depth_of(view, BALL)
    for k in range(3):
        out = one.update(*seen(view, BALL, (k + 1) * FRAME), view, depth[::2, ::2])
    assert len(out.rows) == 0
    assert 'depth picture of 320x240 pixels: expected the 640x480 of CameraInfo' in told[0]
    out = one.update(*seen(view, BALL, 4 * FRAME), view, depth)
    assert len(out.rows) == 1


@pytest.mark.slow
def test_an_object_that_was_moved_is_found_again_and_told_of():
    one, told = locator(motion='still')
    for k in range(10):
        one.update(*seen(view_at(), BALL, (k + 1) * FRAME), view_at())
    for k in range(10, 50):
        out = one.update(*seen(view_at(), (2, -0.3, RADIUS), (k + 1) * FRAME), view_at())
    assert out.rows['x'][0] == pytest.approx(2, abs=0.02)
    assert any('starts anew' in line for line in told)


def test_a_method_that_needs_the_diameter_asks_for_it():
    with pytest.raises(ValueError, match=r'red\.diameter: expected the diameter'):
        LocatorConfig(method='size', colors=(Kind('red', KindConfig()),))


def test_a_diameter_that_no_camera_sees_is_refused():
    """As of a ball of 0.0002 m; below 1e-9 m NumPy warned in each picture."""
    for diameter in (1e-12, 2e-4):
        with pytest.raises(ValueError, match=r'red\.diameter: expected 0, .* at least 0\.001 m'):
            LocatorConfig(colors=(Kind('red', KindConfig(diameter=diameter)),))
