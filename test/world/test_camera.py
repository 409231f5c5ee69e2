from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from colortrack_ros.world import CalibrationError
from colortrack_ros.world import CameraModel
from colortrack_ros.world.view import CalibrationWatch

K = (520.0, 0, 321.5, 0, 515.0, 238.0, 0, 0, 1)
P = (450.0, 0, 310, 0, 0, 450, 245, 0, 0, 0, 1, 0)
PLUMB_BOB = (-0.28, 0.09, 1e-3, -8e-4, -0.012)
RATIONAL = (0.4, 0.1, 1e-3, -5e-4, 0.02, 0.7, 0.15, 0.05)
PRISM = (*RATIONAL, 1e-3, -2e-4, 5e-4, 1e-4)
FISHEYE = (0.02, -0.01, 0.004, -0.001)
LENSES = {
    'none': ('plumb_bob', ()),
    'plumb_bob': ('plumb_bob', PLUMB_BOB),
    'rational_polynomial': ('rational_polynomial', RATIONAL),
    'thin prism': ('rational_polynomial', PRISM),
    'equidistant': ('equidistant', FISHEYE),
}
by_lens = pytest.mark.parametrize('lens', LENSES)


def camera_of(lens, width=640, height=480):
    model, d = LENSES[lens]
    return CameraModel.of(width, height, K, d, model)


def points(count=500, seed=1):
    generator = np.random.default_rng(seed)
    return generator.uniform([-1.8, -1.4, 3], [1.8, 1.4, 6], (count, 3))


@by_lens
def test_points_are_seen_where_opencv_sees_them(lens):
    model, d = LENSES[lens]
    space = points()
    matrix, zero = np.reshape(K, (3, 3)), np.zeros(3)
    if model == 'equidistant':
        expected = cv2.fisheye.projectPoints(space[:, None], zero, zero, matrix, np.array(d))[0]
    else:
        expected = cv2.projectPoints(space, zero, zero, matrix, np.array(d))[0]
    np.testing.assert_allclose(camera_of(lens).project(space), expected[:, 0], atol=1e-9)


@by_lens
def test_a_ray_of_each_pixel_of_the_picture_comes_back_to_it(lens):
    camera = camera_of(lens)
    u, v = np.meshgrid(np.arange(0, 640, 7.0), np.arange(0, 480, 7.0))
    pixels = np.stack([u.ravel(), v.ravel()], axis=1)
    rays = camera.rays(pixels)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1)
    np.testing.assert_allclose(camera.project(3.7 * rays), pixels, atol=1e-5)


@by_lens
def test_the_jacobian_is_that_of_small_steps(lens):
    camera, space = camera_of(lens), points(50)
    space[0] = [0, 0, 2]  # on the axis, where a fisheye's formula divides by zero
    J = camera.linearized(space)[1]
    for axis, step in enumerate(1e-6 * np.eye(3)):
        change = (camera.project(space + step) - camera.project(space - step)) / 2e-6
        np.testing.assert_allclose(J[:, :, axis], change, atol=1e-4)


@by_lens
def test_a_lens_that_is_bent_has_so_much_more_of_its_first_radial_coefficient(lens):
    model, d = LENSES[lens]
    more = np.append(d, np.zeros(0 if len(d) else 4))
    more[0] += 0.1
    wanted = CameraModel.of(640, 480, K, more, model)
    bent = replace(camera_of(lens), lens=camera_of(lens).lens.bent(0.1))
    np.testing.assert_allclose(bent.project(points()), wanted.project(points()), atol=1e-9)


def test_a_depth_gives_the_point_back():
    camera, space = camera_of('plumb_bob'), points()
    again = camera.unproject(camera.project(space), space[:, 2])
    np.testing.assert_allclose(again, space, atol=1e-8)


def test_nothing_is_seen_behind_the_camera_or_where_the_polynomial_folds_back():
    camera = camera_of('plumb_bob')
    behind_and_beside = np.array([[0.1, 0.1, -2], [0, 0, 0], [8, 0, 1.0]])
    assert np.isnan(camera.project(behind_and_beside)).all()
    assert np.isnan(camera.rays(np.array([[1e5, 0.0], [np.nan, 3]]))).all()


def test_a_fisheye_sees_what_is_beside_and_a_little_behind_it():
    camera = CameraModel.of(
        1000, 1000, (250, 0, 500, 0, 250, 500, 0, 0, 1), (0,) * 4, 'equidistant'
    )
    seen = camera.project(np.array([[1.0, 0, -0.1]]))
    assert seen[0, 0] > 500 + 250 * np.pi / 2
    np.testing.assert_allclose(np.cross(camera.rays(seen)[0], [1, 0, -0.1]), 0, atol=1e-9)


def info(**changes):
    given = {'width': 640, 'height': 480, 'distortion_model': 'plumb_bob', 'd': PLUMB_BOB, 'k': K}
    given |= {'p': P, 'binning_x': 0, 'binning_y': 0, 'roi': part_of(0, 0, 0, 0)}
    return SimpleNamespace(**given | changes)


def part_of(x, y, width, height):
    return SimpleNamespace(x_offset=x, y_offset=y, width=width, height=height)


def test_pixels_of_a_binned_part_of_the_sensor_have_the_rays_of_the_whole():
    whole = CameraModel.of_info(info())
    part = CameraModel.of_info(info(binning_x=2, binning_y=2, roi=part_of(100, 50, 400, 301)))
    # pixel (30, 40) of the part covers columns 160 and 161, rows 130 and 131
    np.testing.assert_allclose(
        part.rays(np.array([[30.0, 40.0]])), whole.rays(np.array([[160.5, 130.5]])), atol=1e-12
    )
    assert (part.width, part.height) == (200, 151)


def test_rectified_pictures_have_the_camera_matrix_p_and_no_distortion():
    rectified = CameraModel.of_info(info(), rectified=True)
    np.testing.assert_allclose(
        rectified.project(np.array([[0.2, -0.1, 2.0]])), [[310 + 45, 245 - 22.5]], atol=1e-12
    )


def test_rectified_pictures_of_the_right_camera_of_a_pair_are_refused():
    """Their P says where the left one would see things."""
    right = info(p=(*P[:3], -45.0, *P[4:]))
    with pytest.raises(CalibrationError, match='left camera'):
        CameraModel.of_info(right, rectified=True)
    assert CameraModel.of_info(right).K[0, 0] == K[0]


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'k': (0,) * 9}, 'has not been calibrated'),
        ({'k': (520, 0, 320, 0, float('nan'), 240, 0, 0, 1)}, 'finite'),
        ({'k': (520, 0, 320, 0, -520, 240, 0, 0, 1)}, 'above 0'),
        ({'k': (520, 0, 0, 0, 520, 0, 0, 0, 1)}, 'cx 0, cy 0 px of 640x480 pixels: expected the'),
        ({'k': (520, 0, 32000, 0, 520, 240, 0, 0, 1)}, 'cx 32000'),
        ({'d': (0.1, float('nan'), 0, 0, 0)}, r'with D \[0.1, nan, .* 5 finite numbers'),
        ({'k': (1, 0, 0, 0, 1, 0, 0, 0, 1)}, 'above 0.1 of the picture'),
        ({'width': 0}, '0x480'),
        (
            {'roi': part_of(400, 0, 320, 240)},
            '320x240 pixels at 400, 0: expected a part of the 640',
        ),
        ({'distortion_model': 'brown'}, "'brown': expected one of plumb_bob"),
        ({'d': (0.1, 0.2, 0.3)}, '3 coefficients: expected 0 or 4 or 5 or 8 or 12 or 14'),
        ({'distortion_model': 'equidistant'}, '5 coefficients: expected 4'),
        ({'d': (0.1,) * 14}, 'tilted'),
    ],
)
def test_a_calibration_that_cannot_be_is_refused_with_a_reason(changes, reason):
    with pytest.raises(CalibrationError, match=reason):
        CameraModel.of_info(info(**changes))


@pytest.mark.parametrize('model', ['plumb_bob', 'rational_polynomial'])
@pytest.mark.parametrize('count', [4, 5, 8, 12, 14])
def test_the_number_of_coefficients_is_taken_for_what_it_is_whatever_the_name(model, count):
    """As OpenCV does: drivers call five coefficients rational, and eight plumb_bob."""
    D = np.zeros(14)
    D[:count] = 0.02
    D[12:] = 0.0
    camera = CameraModel.of_info(info(d=tuple(D[:count]), distortion_model=model))
    seen, _ = cv2.projectPoints(points(), np.zeros(3), np.zeros(3), np.reshape(K, (3, 3)), D)
    np.testing.assert_allclose(camera.project(points()), seen[:, 0], atol=1e-9)


def test_no_coefficients_are_no_distortion_whatever_the_model_is_called():
    for model in ('', 'plumb_bob', 'equidistant', 'rational_polynomial'):
        camera = CameraModel.of(640, 480, K, (), model)
        assert np.isfinite(camera.project(points())).all()


def test_the_picture_ends_half_a_pixel_beyond_its_outermost_centers():
    inside = camera_of('none').contains(
        np.array([[-0.5, 0], [639.4, 479.4], [639.5, 0], [0, -0.6], [np.nan, 1]])
    )
    assert inside.tolist() == [True, True, False, False, False]


def zoomed(by, width=640, d=PLUMB_BOB):
    return CameraModel.of(width, 480, np.array(K) * [by, 1, 1, 1, by, 1, 1, 1, 1], d)


@pytest.mark.parametrize('change', [{'by': 1.1}, {'by': 0.9}, {'width': 660}, {'d': ()}])
def test_a_camera_that_is_calibrated_anew_is_noticed_once_and_no_other(change):
    watch = CalibrationWatch()
    assert [watch.see(camera, zoomed(1.0)) for camera in (0, 1, 0)] == [''] * 3
    assert 'calibrated anew' in watch.see(0, zoomed(**{'by': 1.0} | change))
    assert watch.see(0, zoomed(**{'by': 1.0} | change)) == ''
    assert watch.see(1, zoomed(1.0)) == ''


def test_a_lens_that_zooms_by_ten_times_in_six_seconds_is_not_calibrated_anew():
    watch = CalibrationWatch()
    assert not any(watch.see(0, zoomed(10 ** (k / 180))) for k in range(180))
