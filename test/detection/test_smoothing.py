"""Noisy pictures: a dull color is found in them, and what is quiet or given stays as it is."""

from dataclasses import replace
import itertools

import cv2
import numpy as np
import pytest
from support.cameras import encode

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.smoothing import color_noise
from colortrack_ros.detection.smoothing import side_for
from colortrack_ros.detection.smoothing import Smoothing
from colortrack_ros.scenes import open_scene
from colortrack_ros.scenes import SCENES

WALL, BALL, RADIUS = (150, 156, 148), (57, 85, 71), 26  # blue, green, red
OLIVE = ReferenceColor.from_rgb('ball', BALL[::-1])


def picture(rng, sigma, k=0):
    """A dull ball, lit from above, in front of a gray wall as light as its middle, with noise."""
    image = np.full((240, 320, 3), WALL, np.float64) * np.linspace(1, 0.8, 320)[:, None]
    lit = np.linspace(1.9, 1.0, 2 * RADIUS + 1)[:, None, None] * np.array(BALL)
    part = image[120 - RADIUS : 121 + RADIUS, 60 + 9 * k - RADIUS : 61 + 9 * k + RADIUS]
    disc = np.zeros(part.shape[:2], np.uint8)
    cv2.circle(disc, (RADIUS, RADIUS), RADIUS, 255, -1, cv2.LINE_AA)
    part += (lit - part) * disc[..., None] / 255
    return np.clip(image + rng.normal(0, sigma, image.shape), 0, 255).round().astype(np.uint8)


def found(detector, frames):
    """Distances of the only detections from the ball, infinite where there is not one."""
    rows = [detector.detect(frame).rows for frame in frames]
    return np.array(
        [
            np.hypot(row['u'][0] - 60 - 9 * k, row['v'][0] - 120) if len(row) == 1 else np.inf
            for k, row in enumerate(rows)
        ]
    )


@pytest.mark.parametrize(
    ('encoding', 'sigma'),
    [
        *itertools.product(['bgr8', 'bayer_rggb8'], [0, 4, 8, 12]),
        *itertools.product(['yuyv', 'nv12'], [0, 8]),
    ],
)
def test_a_dull_ball_is_found_in_a_noisy_picture(encoding, sigma):
    rng = np.random.default_rng(4)
    frames = [
        replace(encode(picture(rng, sigma, k), encoding), stamp=40_000_000 * k) for k in range(20)
    ]
    detector = Detector(DetectorConfig(colors=(OLIVE,)))
    assert found(detector, frames).max() < 2
    assert detector.trouble == ''


@pytest.mark.parametrize('sigma', [1, 2, 4, 8, 16])
def test_noise_is_measured_on_what_is_even(sigma):
    noise = color_noise(picture(np.random.default_rng(2), sigma))
    assert 0.8 * sigma < noise < 1.05 * sigma


@pytest.mark.parametrize('end', ['dark', 'bright'])
def test_what_the_camera_cuts_off_tells_nothing_of_noise(end):
    image = picture(np.random.default_rng(2), 8)
    image[:, 100:] = np.where(image[:, 100:] < 150, 0, image[:, 100:] - 150)
    image = 255 - image if end == 'bright' else image
    assert 0.8 * 8 < color_noise(image) < 1.05 * 8


def test_noise_that_is_worth_no_blur_is_left():
    assert side_for(picture(np.random.default_rng(2), 2.5)) == 1


@pytest.mark.parametrize('size', [2, 4, 5])
def test_a_texture_is_no_noise(size):
    rng = np.random.default_rng(size)
    leaves = rng.integers(30, 190, (480 // size, 640 // size, 3), np.uint8)
    texture = cv2.resize(leaves, (640, 480), interpolation=cv2.INTER_LINEAR)
    assert color_noise(texture) > 3
    assert side_for(texture) == 1
    texture[:, :250] = 120  # a third of it is even
    assert color_noise(texture) < 1


def test_letters_on_black_are_no_noise():
    image = np.zeros((240, 320, 3), np.uint8)
    for line in range(20, 80, 20):
        cv2.putText(image, 'speed 12 m/s', (5, line), cv2.FONT_HERSHEY_SIMPLEX, 0.4, (90, 200, 60))
    assert side_for(image) == 1


@pytest.mark.parametrize('sigma', [8, 12])
def test_a_dull_ball_is_found_in_a_dark_room(sigma):
    rng = np.random.default_rng(8)
    image = np.full((240, 320, 3), 14, np.float64)
    cv2.circle(image, (160, 120), RADIUS, (14, 14, 45), -1, cv2.LINE_AA)
    detector = Detector(DetectorConfig(colors=(ReferenceColor.from_rgb('ball', (45, 14, 14)),)))
    for k in range(20):
        noisy = (image + rng.normal(0, sigma, image.shape)).clip(0, 255).round().astype(np.uint8)
        (row,) = detector.detect(Frame(noisy, stamp=40_000_000 * k)).rows
        assert np.hypot(row['u'] - 160, row['v'] - 120) < 3


def test_what_the_channels_share_is_no_noise_of_colors():
    rng = np.random.default_rng(3)
    image = picture(rng, 0).astype(np.int16) + rng.normal(0, 10, (240, 320, 1)).astype(np.int16)
    assert color_noise(image.clip(0, 255).astype(np.uint8)) < 1


@pytest.mark.parametrize('shape', [(0, 0, 3), (1, 1, 3), (1, 20, 3), (3, 60, 3), (480, 4, 3)])
def test_a_picture_too_small_to_tell_is_left_alone(shape):
    image = np.random.default_rng(1).integers(20, 200, shape, np.uint8)
    assert side_for(image) == 1
    assert len(Detector(DetectorConfig(colors=(OLIVE,))).detect(Frame(image)).rows) == 0


@pytest.mark.parametrize(
    'image', [np.zeros((99, 99), np.uint8), np.full((99, 99, 3), 255, np.uint8)]
)
def test_gray_and_burnt_out_pictures_have_no_noise(image):
    assert side_for(image) == 1


@pytest.mark.slow
@pytest.mark.parametrize('name', SCENES)
def test_no_scene_is_so_noisy_that_it_is_averaged(name):
    scene = open_scene(f'{name}?width=640&height=360')
    assert {side_for(scene.render(k)) for k in range(0, len(scene), len(scene) // 7)} == {1}


def test_a_given_tolerance_says_what_single_pixels_are():
    image = picture(np.random.default_rng(5), 8)
    exact = ReferenceColor.from_rgb('ball', BALL[::-1], 12.0)
    as_it_is, averaged = (
        Detector(DetectorConfig(colors=(exact,), smoothing=side, erosion_size=1)) for side in (0, 5)
    )
    for detector, seen in ((as_it_is, image), (averaged, cv2.blur(image, (5, 5)))):
        detector.detect(Frame(image))
        single = Detector(DetectorConfig(colors=(exact,), smoothing=1, erosion_size=1))
        single.detect(Frame(seen))
        np.testing.assert_array_equal(detector.labels, single.labels)
    assert np.count_nonzero(averaged.labels) > 1.1 * np.count_nonzero(as_it_is.labels)


def test_noise_is_looked_for_anew_as_time_goes_on_or_back():
    rng, smoothing = np.random.default_rng(6), Smoothing(0)
    for seconds, sigma in [(0, 1), (1, 8), (2, 1), (1, 8), (0, 1)]:
        frame = Frame(picture(rng, sigma), stamp=seconds * NANOSECONDS)
        assert (smoothing.smooth(frame) is frame) == (sigma == 1)


def test_smoothing_ends_with_the_noise():
    rng = np.random.default_rng(6)
    detector = Detector(DetectorConfig(colors=(OLIVE,)))
    noisy = [Frame(picture(rng, 8, k), stamp=40_000_000 * k) for k in range(10)]
    quiet = [Frame(picture(rng, 1, k), stamp=40_000_000 * k) for k in range(10, 20)]
    assert np.isfinite(found(detector, noisy)).all()
    for frame in quiet:
        detector.detect(frame)
    fresh = Detector(DetectorConfig(colors=(OLIVE,), smoothing=1))
    for frame in quiet:
        fresh.detect(frame)
    assert detector.blobs.area[0] == pytest.approx(fresh.blobs.area[0], rel=0.05)


def test_the_view_of_what_moves_shows_averaged_pictures_too():
    rng = np.random.default_rng(7)
    detector = Detector(DetectorConfig(colors=(OLIVE,), smoothing=5, moving_only=True))
    for k in range(10):
        frame = Frame(picture(rng, 12), stamp=100_000_000 * k)
        detector.detect(frame)
    view = detector.background(frame)
    assert view is not None
    assert np.mean(view[1] != 0) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize(('sigma', 'side'), [(3, 3), (6, 3), (12, 5)])
def test_covariances_hold_of_averaged_pictures(sigma, side):
    scene = open_scene(f'five?width=320&height=240&noise={sigma}')
    colors = tuple(ReferenceColor.from_rgb(*color) for color in scene.colors.items())
    detector = Detector(DetectorConfig(colors=colors, smoothing=side))
    squared = []
    for k in range(0, len(scene), 2):
        rows = detector.detect(Frame(scene.render(k), stamp=40_000_000 * k)).rows
        truth = scene.truth(k)
        for ball in truth[truth['visible'] == 1]:
            error = np.array([rows['u'] - ball['u'], rows['v'] - ball['v']]).T
            i = int(np.hypot(*error.T).argmin())
            uu, uv, vv = (rows[name][i] for name in ('cov_uu', 'cov_uv', 'cov_vv'))
            squared.append(error[i] @ np.linalg.solve([[uu, uv], [uv, vv]], error[i]) / 2)
    assert 0.7 < np.mean(squared) < 1.7
