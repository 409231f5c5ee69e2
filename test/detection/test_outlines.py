"""How well the center of a ball is known by its outline: blurred, rounded, covered, at a border."""

import cv2
import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.blur import fitting_profiles
from colortrack_ros.detection.blur import Profiles
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.scenes.shapes import draw_ball

FIXED = ReferenceColor.from_rgb('red', (205, 58, 34), 50.0)


def red_ball(center, way, radius):
    """A picture of a shaded ball before a wall, smeared along way, (2,) [px]."""
    image = np.full((160, 240, 3), (110, 105, 100), np.uint8)
    draw_ball(image, center, way, radius, np.array((34, 58, 205), np.float32))
    return image


def toward(angle, smear):
    """The way of a smear of so many px."""
    return smear * np.array([np.cos(angle), np.sin(angle)])


def blurred(smear, angle=0.0, cover=None):
    """A shaded ball of 24 px, smeared by so many px, and a bar of the wall's color before it."""
    image = red_ball(np.array([120.3, 80.2]), toward(angle, smear), 24.0)
    if cover is not None:
        image[:, cover:] = (110, 105, 100)
    return image


@pytest.mark.parametrize('smear', [4.0, 8.0, 12.0])
def test_the_blur_of_an_outline_is_measured_along_the_way_of_the_exposure(smear):
    seen = []
    for angle in (0.0, np.pi / 2):
        image = blurred(smear, angle)
        runs = LabelImage.empty(*image.shape[:2])
        runs.pixels[...] = image[..., 2] > 140
        blobs = find_blobs(runs, 20)
        profiles = Profiles.of(blobs)
        (*_, (blur,)) = fitting_profiles(Frame(image), blobs, profiles)
        u, v = np.sqrt(blur.diagonal())
        seen.append((u, v) if angle == 0 else (v, u))
    assert seen[0][0] == pytest.approx(smear, abs=2.5)
    assert seen[1][0] == pytest.approx(smear, abs=2.5)
    assert max(seen[0][1], seen[1][1]) < 4
    v, u = np.indices((160, 240))
    even = np.full((160, 240, 3), (110, 105, 100), np.uint8)
    even[(v - 80) ** 2 + (u - 120) ** 2 < 24**2] = (34, 58, 205)
    even = cv2.blur(even, (round(smear) + 1, 1))
    (row,) = Detector(DetectorConfig()).detect(Frame(even)).rows
    assert row['cov_uu'] > 2 * row['cov_vv']


@pytest.mark.parametrize('tolerance', [20.0, 25.0, 30.0])
@pytest.mark.parametrize('smear', [0.4, 0.5, 0.6])
def test_a_smear_that_a_tight_tolerance_cuts_off_is_in_the_covariance(smear, tolerance):
    squared = []
    for k in range(8):
        center = np.array([120, 80]) + np.random.default_rng(k).random(2)
        image = red_ball(center, toward(np.pi * k / 8, 32 * smear), 32.0)
        color = ReferenceColor.from_rgb('ball', tuple(map(float, image[80, 120, ::-1])), tolerance)
        (row, *_) = Detector(DetectorConfig(colors=(color,))).detect(Frame(image)).rows
        error = np.array([row['u'], row['v']]) - center
        covariance = [[row['cov_uu'], row['cov_uv']], [row['cov_uv'], row['cov_vv']]]
        squared.append(error @ np.linalg.solve(covariance, error) / 2)
    assert np.mean(squared) < 1.6


@pytest.mark.parametrize('smear', [6.0, 9.0, 12.0])
def test_blur_along_the_light_counts_more_than_as_much_blur_across_it(smear):
    # The light comes from the upper left. Both ways, u and v are blurred alike.
    along, across = (
        Detector(DetectorConfig()).detect(Frame(blurred(smear, angle))).rows[0]
        for angle in (np.pi / 4, -np.pi / 4)
    )
    squared = []
    for row in (along, across):
        error = row['u'] - 120.3 + row['v'] - 80.2
        variance = row['cov_uu'] + row['cov_vv'] + 2 * row['cov_uv']
        squared.append(error**2 / variance)
    assert squared[0] < 2 * squared[1]
    assert along['cov_uv'] > 2 * across['cov_uv']


@pytest.mark.parametrize('radius', [3.0, 5.0, 9.0, 16.0, 30.0, 45.0])
def test_the_rounding_of_an_outline_to_pixels_is_known_at_every_size(radius):
    random, squared = np.random.default_rng(round(radius)), []
    v, u = np.indices((120, 120))
    for _ in range(100):
        center, r = 60 + random.random(2), radius + random.uniform(-0.5, 0.5)
        image = np.full((120, 120, 3), (110, 105, 100), np.uint8)
        image[np.hypot(u - center[0], v - center[1]) < r] = (34, 58, 205)
        (row,) = Detector(DetectorConfig(min_area=1, colors=(FIXED,))).detect(Frame(image)).rows
        error = np.array([row['u'], row['v']]) - center
        squared.append(error**2 / [row['cov_uu'], row['cov_vv']])
    assert 0.8 < np.mean(squared) < 1.25


@pytest.mark.parametrize('gap', [0.5, 1.5])
def test_a_ball_beside_the_border_is_not_thought_to_end_there(gap):
    variances = []
    for u in (22.0 + gap, 120.0):
        image = red_ball(np.array([u, 80.2]), np.array([3.0, 0.0]), 22.0)
        (row,) = Detector(DetectorConfig(colors=(FIXED,))).detect(Frame(image)).rows
        variances.append(row['cov_uu'])
    assert variances[0] < 2.5 * variances[1]


def squared_errors(radius, smear, tolerance):
    """(2,) of u and v over their variances, of balls that are lit from above, means over 12."""
    red = ReferenceColor.from_rgb('red', (205, 58, 34), tolerance)
    found = []
    for seed in range(12):
        random = np.random.default_rng(seed)
        center = np.array([120, 80]) + random.random(2)
        image = red_ball(center, np.array(smear), radius)
        image = np.clip(image + random.normal(0, 2.5, image.shape), 0, 255).astype(np.uint8)
        (row,) = Detector(DetectorConfig(colors=(red,))).detect(Frame(image)).rows
        u, v = row['u'] - center[0], row['v'] - center[1]
        found.append((u**2 / row['cov_uu'], v**2 / row['cov_vv']))
    return np.mean(found, axis=0)


STRANGERS = {
    'dim': {'gain': 0.7},
    'bright': {'gain': 1.15},
    'clean': {'noise': 0.0},
    'noisy': {'noise': 6.0},
    'unsharp': {'sigma': 1.2},
    'out of focus': {'sigma': 2.0, 'noise': 4.0},
    'thrown': {'smear': 9.0, 'gain': 0.85},
    'close': {'radius': 38.0, 'noise': 1.0},
    'far': {'radius': 10.0, 'sigma': 0.7},
}
"""Cameras and balls of no rendered scene: exposure, noise and focus."""


def stranger(random, radius=20.0, gain=1.0, noise=2.0, sigma=0.0, smear=0.0):
    """A frame of a red ball before a wall, and the ball's center."""
    center, angle = np.array([120, 80]) + random.random(2), random.uniform(0, 2 * np.pi)
    levels = gain * red_ball(center, toward(angle, smear), radius).astype(np.float32)
    if sigma:
        levels = cv2.GaussianBlur(levels, (0, 0), sigma)
    levels += random.normal(0, noise, levels.shape)
    return Frame(np.clip(levels, 0, 255).astype(np.uint8)), center


@pytest.mark.slow
@pytest.mark.parametrize('tolerance', [0.0, 50.0])
def test_balls_before_cameras_of_no_scene_are_known_as_well_as_is_said(tolerance):
    squared = {}
    for name, options in STRANGERS.items():
        # Without a tolerance, a color is picked in the picture.
        gain = 1.0 if tolerance else options.get('gain', 1.0)
        rgb = np.minimum(gain * np.array([205, 58, 34]), 255)
        red = ReferenceColor.from_rgb('red', tuple(rgb.astype(int).tolist()), tolerance)
        random = np.random.default_rng(0)
        squared[name] = []
        for _ in range(8):
            frame, center = stranger(random, **options)
            (row,) = Detector(DetectorConfig(colors=(red,))).detect(frame).rows
            error = np.array([row['u'], row['v']]) - center
            covariance = [[row['cov_uu'], row['cov_uv']], [row['cov_uv'], row['cov_vv']]]
            squared[name].append(error @ np.linalg.solve(covariance, error) / 2)
    assert 0.7 < np.mean(list(squared.values())) < 1.4
    assert all(0.5 < np.mean(own) < 3 for own in squared.values()), squared


def test_a_ball_that_is_smeared_over_all_of_itself_is_not_thought_worse_for_its_lack_of_an_inside():
    assert squared_errors(8.0, (12.0, 6.0), 50.0).mean() > 0.8


def test_a_blurred_ball_before_things_like_it_is_known_worse():
    sigmas = []
    for corner in ((110, 105, 100), (60, 75, 150)):
        image = np.full((160, 240, 3), (110, 105, 100), np.uint8)
        image[:80, 120:] = corner
        draw_ball(
            image, np.array([120.3, 80.2]), np.array([8.0, 0.0]), 24.0, np.array((34, 58, 205))
        )
        (row,) = Detector(DetectorConfig()).detect(Frame(image)).rows
        sigmas.append(np.sqrt(row['cov_uu']))
    even, uneven = sigmas
    assert row['u'] - 120.3 > 0.5
    assert uneven > 1.5 * even


def test_a_ball_behind_something_is_known_worse_the_less_of_it_is_left():
    detector = Detector(DetectorConfig())
    (whole,) = detector.detect(Frame(blurred(0.0))).rows
    errors, sigmas = [], []
    for cover in (136, 128, 120):
        (row,) = detector.detect(Frame(blurred(0.0, cover=cover))).rows
        errors.append(whole['u'] - row['u'])
        sigmas.append(np.sqrt(row['cov_uu']))
    assert 2 < errors[0] < errors[-1]
    assert sigmas == sorted(sigmas)
    assert (np.array(errors) < 3 * np.array(sigmas)).all()
    assert whole['cov_uu'] < 0.1 < sigmas[0]


def test_what_always_has_the_shape_of_something_covered_is_known_well():
    detector = Detector(DetectorConfig())
    v, u = np.indices((160, 240))
    for k in range(3):
        image = np.full((160, 240, 3), 110, np.uint8)
        image[(v > 50) & (v < 110) & (np.abs(u - 100 - k) < (v - 48) / 2)] = (34, 58, 205)
        (cone,) = detector.detect(Frame(image, stamp=k * NANOSECONDS // 30)).rows
    assert np.sqrt(cone['cov_uu']) < 4
    ball = Detector(DetectorConfig())
    ball.detect(Frame(blurred(0.0)))
    (cut,) = ball.detect(Frame(image)).rows
    assert np.sqrt(cut['cov_uu']) > 8
