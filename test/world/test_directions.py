"""Every direction has a pixel, in the picture or beside it."""

import itertools

import numpy as np
import pytest

from colortrack_ros.world import CameraModel
from colortrack_ros.world import Pose
from colortrack_ros.world.directions import directions_of
from colortrack_ros.world.directions import pixels_of
from colortrack_ros.world.view import View

K = (300, 0, 320, 0, 310, 240, 0, 0, 1)
CAMERAS = {
    'plain': CameraModel.of(640, 480, K),
    'barrel': CameraModel.of(640, 480, K, (-0.28, 0.09, 1e-3, -8e-4, -0.01)),
    'fisheye': CameraModel.of(640, 480, K, (0.02, -0.01, 0.003, 0.0), 'equidistant'),
}


@pytest.fixture(params=CAMERAS)
def camera(request):
    return CAMERAS[request.param]


def anywhere(count):
    rays = np.random.default_rng(0).normal(size=(count, 3))
    return rays / np.linalg.norm(rays, axis=1)[:, None]


def test_a_direction_behind_the_camera_has_a_pixel_that_leads_back_to_it(camera):
    rays = anywhere(500)
    pixels = pixels_of(camera, rays)
    again = directions_of(camera, pixels)
    # where the picture ends the lens hands over, there they may differ by a part of a pixel
    assert np.median(np.abs(again - rays)) < 1e-6
    assert np.abs(again - rays).max() < 0.01


def test_in_the_picture_they_are_those_of_the_lens(camera):
    pixels = np.random.default_rng(0).uniform((5, 5), (634, 474), (200, 2))
    assert directions_of(camera, pixels) == pytest.approx(camera.rays(pixels))
    assert pixels_of(camera, camera.rays(pixels)) == pytest.approx(pixels, abs=1e-3)


def test_what_is_not_seen_has_no_pixel_in_the_picture(camera):
    rays = anywhere(500)
    hidden = ~np.isfinite(camera.project(rays)).all(axis=1)
    assert not camera.contains(pixels_of(camera, rays[hidden])).any()


def test_straight_ahead_and_straight_behind_are_somewhere(camera):
    axis = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    ahead, behind = pixels_of(camera, axis)
    assert ahead == pytest.approx((320, 240))
    assert np.hypot(*(behind - ahead)) > 640


MOUNT = Pose.of_rpy((0.1, 0, 0.5), (0, 0.25, 0))


def seen_by(view, points):
    return view.camera.project(view.optical.inverse().apply(np.array(points)))


def test_a_view_tells_where_driving_takes_what_is_on_the_ground_and_turning_what_is_far(camera):
    last = View(camera, Pose.of_rpy((1, 2, 3), (0, 0, 0.2)), MOUNT)
    now = View(camera, Pose.of_rpy((1.1, 2.05, 3), (0, 0, 0.26)), MOUNT)
    points = [(3.0, 2.2, 3.0), (4.0, 3.5, 3.0), (1e7, 2e6, 2e6)]
    before = seen_by(last, points)
    near = last.nearness(before, before)
    away = [np.linalg.norm(np.array(p) - last.optical.t) for p in points]
    assert near == pytest.approx(1 / np.array(away), abs=1e-6)
    moved, J, nearer = now.moved(before, last, near)
    assert moved == pytest.approx(seen_by(now, points), abs=0.01)
    away = [np.linalg.norm(np.array(p) - now.optical.t) for p in points]
    assert nearer == pytest.approx(1 / np.array(away), abs=1e-6)
    step = np.array([1.0, -1.0])
    beside, _, _ = now.moved(before + step, last, near)
    assert beside - moved == pytest.approx(J @ step, abs=0.03)
    assert last.moved(moved, now, nearer)[0] == pytest.approx(before, abs=0.01)


def test_how_near_a_thing_is_follows_from_where_it_touches_the_ground(camera):
    """A post whose middle is 0.3 m high, one that is higher than the camera, one in the sky."""
    last, now = (View(camera, Pose.of_rpy((x, 0, 0), (0, 0, 0)), MOUNT) for x in (0, 0.4))
    middles = [(2.0, 0.5, 0.3), (2.5, -0.4, 0.55), (3.0, 0.0, 0.9)]
    feet = [(2.0, 0.5, 0.0), (2.5, -0.4, 0.0), (3.0, 0.0, 0.6)]
    before = seen_by(last, middles)
    near = last.nearness(before, seen_by(last, feet))
    assert near[2] == 0
    moved, _, _ = now.moved(before[:2], last, near[:2])
    assert moved == pytest.approx(seen_by(now, middles[:2]), abs=0.01)


def test_a_camera_on_the_ground_does_not_know_how_near_anything_is(camera):
    view = View(camera, Pose.of_rpy((0, 0, 0), (0, 0, 0)), Pose.of_rpy((0, 0, 0.01), (0, 0, 0)))
    pixels = np.array([[320.0, 400.0]])
    assert view.nearness(pixels, pixels + 20.0).tolist() == [0.0]


def test_what_drives_by_beside_or_behind_the_camera_is_followed_around_it(camera):
    """Step by step, as no picture shows it, to where it is straight behind."""
    thing, places = (1.5, 0.3, 0.1), np.linspace(0.0, 3.0, 91)
    views = [View(camera, Pose.of_rpy((x, 0, 0), (0, 0, 0)), MOUNT) for x in places]
    x, foot = (seen_by(views[0], [point]) for point in (thing, (1.5, 0.3, 0.0)))
    near = views[0].nearness(x, foot)
    for last, now in itertools.pairwise(views):
        x, _, near = now.moved(x, last, near)
    d = views[-1].optical.inverse().apply(np.array([thing]))
    assert directions_of(camera, x) == pytest.approx(d / np.linalg.norm(d), abs=0.01)
    assert near == pytest.approx(1 / np.linalg.norm(d), rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize('rate', [0.0, 5.0, 20.0, 60.0])
def test_what_its_own_velocity_keeps_behind_the_camera_stays_as_certain_as_it_is(camera, rate):
    """A robot that stands or turns [degrees/s], while tracks out of sight fly on for 4 s."""
    rng = np.random.default_rng(0)
    x, way = rng.uniform((-1000, -800), (1600, 1300), (200, 2)), 20 * rng.normal(size=(200, 2))
    cov, near = np.tile(100 * np.eye(2), (200, 1, 1)), np.full(200, 0.3)
    yaws = np.radians(rate) * np.arange(121) / 30
    views = [View(camera, Pose.of_rpy((0, 0, 0), (0, 0, yaw)), MOUNT) for yaw in yaws]
    for last, now in itertools.pairwise(views):
        before = x + way
        x, J, near = now.moved(before, last, near)
        cov = J @ cov @ J.swapaxes(1, 2) + 100 * np.eye(2)
    assert np.abs(cov).max() < 1e4**2
    if rate == 0:
        beyond = np.hypot(*(before - K[2:6:3]).T) > 300 * np.pi
        assert beyond.any()
        ways = x[beyond] - K[2:6:3], before[beyond] - K[2:6:3]
        sides = [each / np.linalg.norm(each, axis=1)[:, None] for each in ways]
        assert sides[0] == pytest.approx(sides[1], abs=0.02)


def test_a_picture_shows_a_thing_of_which_a_part_is_inside():
    view = View(CAMERAS['plain'], Pose.of_rpy((0, 0, 0), (0, 0, 0)), MOUNT)
    x = np.array([(-8.0, 100.0), (-12.0, 100.0), (300.0, 489.0), (300.0, 491.0)])
    reach = np.full((4, 2, 2), 10.0)
    assert view.shows(x, reach).tolist() == [True, False, True, False]
