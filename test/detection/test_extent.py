"""Where a color ends among the colors of a picture."""

import numpy as np

from colortrack_ros.detection import extent
from colortrack_ros.detection.lab import lab_from_rgb

DARK_RED, GRAY = (60, 33, 40), 185


def picture_of(*groups):
    """One row of pixels of these colors, with noise."""
    rgb = np.concatenate(groups)
    noisy = rgb + np.random.default_rng(0).normal(0, 3, rgb.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)[None, :, ::-1]


def test_a_dark_cloth_is_no_shade_of_a_dark_ball_before_it():
    shades = np.linspace(DARK_RED, (26, 26, 26), 100)
    cloth, wall = np.full((20_000, 3), 24), np.full((150_000, 3), GRAY)
    counts = extent.count_colors(picture_of(shades, cloth, wall), 'bgr8')
    lab = tuple(lab_from_rgb(np.array([DARK_RED]))[0].tolist())
    found = extent.find_extent(counts, lab)
    assert found is not None
    assert found.pixels < 1000, 'the cloth has 20,000'
