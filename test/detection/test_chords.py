"""What is cut off an object by shading or highlights is seen by the hue of its chords."""

import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.blur import fitting_profiles
from colortrack_ros.detection.blur import PROFILE_SAMPLES
from colortrack_ros.detection.blur import Profiles
from colortrack_ros.detection.chords import outside_share
from colortrack_ros.detection.label_image import LabelImage

RED, FINER = np.array([0.55, 0.03, 0.02]), 4


def lit_ball(center, radius, ambient, gloss=0.0):
    """A matte or glossy ball lit from the upper left, in linear light, before an even wall."""
    side = (np.arange(120 * FINER) + 0.5) / FINER - 0.5
    u, v = (side - center[0]) / radius, (side[:, None] - center[1]) / radius
    depth = np.sqrt(np.maximum(1 - u * u - v * v, 0))
    toward = (0.7 * depth - 0.5 * u - 0.5 * v).clip(0)
    half = (0.92 * depth - 0.27 * u - 0.27 * v).clip(0)
    light = (ambient + (1 - ambient) * toward)[..., None] * RED + gloss * (half**60)[..., None]
    image = np.where((u * u + v * v < 1)[..., None], light, 0.2)
    image = image.reshape(120, FINER, 120, FINER, 3).mean(axis=(1, 3)).clip(0, 1)
    return image ** (1 / 2.2) * 255


def turned_box(center, half, turn):
    """A box with these half sides, turned by an angle [rad], before an even wall."""
    side = (np.arange(120 * FINER) + 0.5) / FINER - 0.5
    u, v = side - center[0], side[:, None] - center[1]
    along, across = u * np.cos(turn) + v * np.sin(turn), v * np.cos(turn) - u * np.sin(turn)
    inside = (np.abs(along) < half[0]) & (np.abs(across) < half[1])
    image = np.where(inside[..., None], RED, 0.2)
    return image.reshape(120, FINER, 120, FINER, 3).mean(axis=(1, 3)) ** (1 / 2.2) * 255


def squared_error(tolerance, draw):
    """Mean squared error over its covariance, divided by two, of things at random places."""
    squared = []
    for seed in range(12):
        random = np.random.default_rng(seed)
        center = 60 + random.random(2)
        image = draw(center, random) + random.normal(0, 2, (120, 120, 3))
        image = image.clip(0, 255).astype(np.uint8)
        color = ReferenceColor.from_rgb('ball', tuple(map(float, image[60, 60])), tolerance)
        (row, *_) = Detector(DetectorConfig(colors=(color,))).detect(Frame(image, 'rgb8')).rows
        error = np.array([row['u'], row['v']]) - center
        covariance = [[row['cov_uu'], row['cov_uv']], [row['cov_uv'], row['cov_vv']]]
        squared.append(error @ np.linalg.solve(covariance, error) / 2)
    return np.mean(squared)


@pytest.mark.parametrize('radius', [10.0, 16.0, 24.0])
def test_a_dark_side_that_the_tolerance_cuts_off_is_in_the_covariance(radius):
    assert squared_error(25.0, lambda center, _: lit_ball(center, radius, 0.3)) < 3


@pytest.mark.parametrize('radius', [12.0, 16.0, 24.0, 40.0])
def test_a_highlight_that_the_tolerance_cuts_out_is_in_the_covariance(radius):
    assert squared_error(40.0, lambda center, _: lit_ball(center, radius, 0.8, 0.9)) < 3


@pytest.mark.parametrize('half', [(12.0, 12.0), (20.0, 10.0), (30.0, 6.0)])
def test_that_a_box_is_turned_makes_its_center_no_less_certain(half):
    error = squared_error(50.0, lambda center, random: turned_box(center, half, random.random()))
    assert 0.2 < error < 3


def test_the_rounding_of_sides_along_rows_is_in_the_covariance():
    error = squared_error(50.0, lambda center, _: turned_box(center, (20.0, 10.0), 0.0))
    assert 0.5 < error < 2


def shares(image):
    """Shares of the surroundings along the profiles of the only blob of a picture."""
    runs = LabelImage.empty(*image.shape[:2])
    runs.pixels[...] = (image[..., 0] > 150) & (image[..., 1] < 90)
    blobs = find_blobs(runs, 20)
    profiles = Profiles.of(blobs)
    return outside_share(fitting_profiles(Frame(image, 'rgb8'), blobs, profiles)[0])[0]


def test_the_dark_side_of_an_object_is_the_object():
    image = np.full((60, 60, 3), 120, np.uint8)
    image[20:40, 15:45] = 200, 40, 40
    image[20:40, 39:45] = 120, 24, 24
    high, low = shares(image)[0, 0]
    assert (high[:PROFILE_SAMPLES] < 0.1).all()
    assert (high[PROFILE_SAMPLES : PROFILE_SAMPLES + 4] < 0.1).all()
    assert high[-1] > 0.9
    assert low[PROFILE_SAMPLES] > 0.9


def test_an_object_ends_where_a_wall_begins_that_is_brighter_farther_away():
    image = np.full((60, 60, 3), 128, np.uint8)
    image[15:45, 10:50] = 118
    image[20:40, 15:45] = 200, 40, 40
    share = shares(image)
    assert (share[..., :PROFILE_SAMPLES] < 0.01).all()
    assert (share[..., PROFILE_SAMPLES:] > 0.99).all()


def test_a_gray_object_is_told_from_gray_surroundings_by_its_brightness():
    image = np.full((60, 60, 3), 60, np.uint8)
    image[20:40, 15:45] = 240
    runs = LabelImage.empty(60, 60)
    runs.pixels[...] = image[..., 0] > 150
    blobs = find_blobs(runs, 20)
    profiles = Profiles.of(blobs)
    for frame in (Frame(image), Frame(image[..., 0].copy(), 'mono8')):
        share = outside_share(fitting_profiles(frame, blobs, profiles)[0])
        assert (share[..., :PROFILE_SAMPLES] < 0.1).all()
        assert (share[..., PROFILE_SAMPLES:] > 0.9).all()
