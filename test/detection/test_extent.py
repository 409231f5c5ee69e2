"""Where a color ends among the colors of a picture."""

import numpy as np
import pytest

from colortrack_ros.detection import extent
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.lab import rgb_from_lab

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


@pytest.mark.parametrize('seed', range(8))
def test_colors_beyond_a_gap_that_only_the_own_shape_of_a_color_shows_are_left_outside(seed):
    """A yellow from orange to green, and as much paler things as make one color of both at first.

    Around the first, round shape, both valleys are as deep to a few percent.
    """
    rng = np.random.default_rng(seed)
    groups = [
        rng.uniform((72, -17, 65), (92, 23, 71), (930, 3)),
        rng.uniform((70, -20, 25), (90, 15, 50), (1500, 3)),
        rng.normal((45, -45, 30), 4, (20_000, 3)),
        rng.uniform((40, -40, 0), (100, 40, 100), (4000, 3)),
    ]
    rgb = rgb_from_lab(np.concatenate(groups))
    counts = extent.count_colors(rgb[None, :, ::-1].astype(np.uint8), 'bgr8')
    found = extent.find_extent(counts, (82.0, 3.0, 68.0))
    assert found is not None
    assert found.pixels == pytest.approx(930, rel=0.6), (
        'all of both are 2,430, and more of the room'
    )
