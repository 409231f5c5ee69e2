"""Every direction has a pixel, in the picture or beside it."""

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
    moved, J = now.moved(seen_by(last, points), last)
    assert moved == pytest.approx(seen_by(now, points), abs=0.01)
    beside = seen_by(last, points) + np.array([1.0, -1.0])
    assert now.moved(beside, last)[0] - moved == pytest.approx(J @ [1.0, -1.0], abs=0.03)
    assert last.moved(moved, now)[0] == pytest.approx(seen_by(last, points), abs=0.01)


def test_of_what_is_above_the_ground_a_part_of_the_shift_is_told(camera):
    last, now = (View(camera, Pose.of_rpy((x, 0, 0), (0, 0, 0)), MOUNT) for x in (0, 0.2))
    before, after = (seen_by(view, [(2.0, 0.5, 0.2)]) for view in (last, now))
    told = now.moved(before, last)[0] - before
    assert 0.3 < np.linalg.norm(told) / np.linalg.norm(after - before) < 1
