"""Shades beyond the gap where a color ends belong to it if they lie on its things."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.cells import cell_bounds
from colortrack_ros.detection.cells import CELLS
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.extent import LARGEST_SHARE
from colortrack_ros.detection.extent import sample_colors
from colortrack_ros.detection.growth import HALF_WAY
from colortrack_ros.detection.growth import nearest_sample
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.lab import linear_from_srgb
from colortrack_ros.detection.shade_follower import ShadeFollower
from colortrack_ros.detection.shades import reach_of
from colortrack_ros.detection.shades import shades_beyond

RED, SHADE, WALL = (200, 40, 40), (160, 32, 32), (120, 160, 200)


def picture(*discs):
    image = np.full((240, 320, 3), WALL, np.uint8)
    for center, radius, rgb in discs:
        cv2.circle(image, center, radius, rgb, cv2.FILLED)
    return sample_colors(image, 'rgb8')


def red():
    """An extent that ends at 2/3 of the way to the shade."""
    lab, shade = lab_from_rgb(np.array([RED, SHADE]))
    L, a, b = np.maximum(np.abs(shade - lab), 4.0) * 2 / 3 * np.sqrt(3)
    return Extent(tuple(lab.tolist()), (L, a, b), 0.1, 1.0)


def test_a_shade_on_a_thing_is_reached():
    cells = picture(((100, 100), 33, SHADE), ((100, 100), 30, RED))
    assert 1.5 < reach_of(*cells, red(), []) <= HALF_WAY


@pytest.mark.parametrize('radius', [5, 60])
def test_one_that_is_elsewhere_too_is_not(radius):
    discs = ((100, 100), 33, SHADE), ((100, 100), 30, RED), ((240, 130), radius, SHADE)
    assert reach_of(*picture(*discs), red(), []) < 1.5


def test_nor_is_one_that_there_is_more_of_than_of_the_thing():
    assert reach_of(*picture(((100, 100), 50, SHADE), ((100, 100), 30, RED)), red(), []) < 1.5


def test_specks_elsewhere_are_no_things_that_a_shade_may_lie_on():
    discs = [((200 + 6 * k, 40 + 6 * j), 2, SHADE) for k in range(8) for j in range(8)]
    specks = [((200 + 6 * k, 40 + 6 * j), 1, RED) for k in range(8) for j in range(8)]
    thing = ((100, 100), 33, SHADE), ((100, 100), 30, RED)
    assert reach_of(*picture(*discs, *specks, *thing), red(), []) < 1.5
    assert reach_of(*picture(*specks, *thing), red(), []) > 1.5


def test_without_a_thing_nothing_is_known():
    assert reach_of(*picture(), red(), []) is None
    assert reach_of(*picture(((100, 100), 1, RED)), red(), []) is None


def test_shades_are_found_up_to_the_border_of_the_picture():
    cells = picture(((0, 0), 33, SHADE), ((0, 0), 30, RED), ((319, 239), 30, RED))
    assert reach_of(*cells, red(), []) > 1.5


def graded(*discs, least=0.15):
    """Cells and counts of matt discs that are lit from above: least of its light at the bottom."""
    image = np.full((240, 320, 3), WALL, float)
    v, u = np.mgrid[:240, :320]
    for (x, y), radius, rgb in discs:
        light = least + (1 - least) * np.clip((y + radius - v) / (2 * radius), 0, 1)
        linear = light[..., None] * linear_from_srgb(rgb)
        inside = np.hypot(u - x, v - y) < radius
        image[inside] = 255 * (linear ** (1 / 2.2))[inside]
    image += np.random.default_rng(0).normal(0, 3, image.shape)
    return sample_colors(image.clip(0, 255).astype(np.uint8), 'rgb8')


DARK = Extent((26.0, 43.0, 31.0), (12.0, 8.0, 8.0), 0.1, 1.0)


def test_a_color_goes_along_its_shades_from_the_dark_side_of_a_thing_to_the_light_one():
    shades = np.array(shades_beyond(*graded(((100, 100), 40, RED)), DARK, []))
    light = lab_from_rgb(np.array(RED))
    assert len(shades) > 2
    assert np.abs(shades - light).max(axis=1).min() < 8.0
    assert (np.diff(np.sort(shades[:, 0])) < 8.0).all(), 'a tube without holes'


def test_not_where_another_thing_has_a_shade():
    cells, _ = graded(((100, 100), 40, RED))
    v, u = np.mgrid[:240, :320]
    cells[np.hypot(u - 250, v - 100) < 20] = cells[85, 100]
    shades = np.array(
        shades_beyond(cells, np.bincount(cells.reshape(-1), minlength=CELLS), DARK, [])
    )
    assert shades.reshape(-1, 3)[:, 0].max(initial=0) < 34, 'that thing has 39'


def test_nor_where_there_is_more_of_a_shade_than_of_the_color():
    cells, _ = graded(((100, 100), 40, RED))
    v, u = np.mgrid[:240, :320]
    cells[(np.hypot(u - 100, v - 100) > 40) & (v < 200)] = cells[80, 100]
    shades = np.array(
        shades_beyond(cells, np.bincount(cells.reshape(-1), minlength=CELLS), DARK, [])
    )
    assert shades.reshape(-1, 3)[:, 0].max(initial=0) < 34


def test_nor_over_more_of_the_picture_than_a_color_may_cover():
    cells, counts = graded(((160, 120), 120, RED))
    shades = shades_beyond(cells, counts, DARK, [])
    color = cell_bounds()[0].T
    inside = nearest_sample(color, (DARK.lab, *shades), np.array(DARK.axes)) < 1
    assert counts @ inside < LARGEST_SHARE * cells.size


def with_patch(radius):
    """The disc of graded(), and a thing of one of its shades beside it."""
    cells, _ = graded(((100, 100), 40, RED))
    v, u = np.mgrid[:240, :320]
    cells[np.hypot(u - 220, v - 100) < radius] = cells[85, 100]
    return cells, np.bincount(cells.reshape(-1), minlength=CELLS).astype(float)


@pytest.mark.parametrize(
    ('before', 'radius', 'kept'), [(6, 25, True), (6, 80, False), (1, 25, False)]
)
def test_shades_known_for_long_are_kept_if_most_of_the_thing_would_be_lost(before, radius, kept):
    follower = ShadeFollower()
    for k in range(12):
        picture = with_patch(radius if k >= before else 0)
        follower.follow(*picture, DARK, [], 0.2, k * NANOSECONDS)
    lightest = np.array(follower.shades).reshape(-1, 3)[:, 0].max(initial=0)
    assert (lightest > 40) == kept, 'the other thing has 39'


def test_what_grows_after_a_search_does_not_make_the_shades_larger():
    follower, larger = ShadeFollower(), replace(DARK, axes=(14.4, 9.6, 9.6))
    picture = graded(((100, 100), 40, RED))
    for k in range(3):
        follower.follow(*picture, DARK, [], 0.2, k * NANOSECONDS)
    searched = follower.whole(DARK)
    assert follower.shades
    assert follower.whole(larger) == searched
    for k in range(3, 6):
        follower.follow(*picture, larger, [], 0.2, k * NANOSECONDS)
    assert follower.whole(larger).axes > searched.axes, 'a search has tried it'


def test_other_light_moves_the_shades_and_two_searches_in_a_row_change_them():
    follower, few, many = ShadeFollower(), with_patch(25), with_patch(0)
    for k in range(3):
        follower.follow(*few, DARK, [], 0.2, k * NANOSECONDS)
    before = follower.shades
    follower.relight(np.full(3, 0.8))
    moved = np.array(follower.shades)
    scale = np.cbrt(0.8)  # of L + 16, a, and b
    away = np.array([16.0, 0.0, 0.0])
    assert moved + away == pytest.approx(scale * (np.array(before) + away), rel=0.04)
    follower.relight(np.full(3, 1 / 0.8))
    follower.follow(*many, DARK, [], 0.2, 2 * NANOSECONDS + 1)
    assert np.array(follower.shades) == pytest.approx(np.array(before))
    follower.follow(*many, DARK, [], 0.2, 4 * NANOSECONDS)
    assert len(follower.shades) > len(before)


@pytest.mark.parametrize(('most', 'kept'), [(5 * 40**2, True), (40**2, False)])
def test_without_the_color_its_shades_have_no_more_pixels_than_the_thing_may(most, kept):
    follower, thing = ShadeFollower(), graded(((100, 100), 40, RED))
    for k in range(3):
        follower.follow(*thing, DARK, [], 0.2, k * NANOSECONDS)
    known = follower.whole(DARK), follower.shades
    counts = thing[1].copy()
    counts[nearest_sample(cell_bounds()[0].T, (DARK.lab,), np.array(DARK.axes)) < 1] = 0
    assert follower.leave(counts, DARK, most) is not kept
    assert ((follower.whole(DARK), follower.shades) == known) is kept
    assert bool(follower.shades) is kept
