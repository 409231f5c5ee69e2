"""Shades beyond the gap where a color ends belong to it if they lie on its things."""

import cv2
import numpy as np
import pytest

from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.extent import HALF_WAY
from colortrack_ros.detection.extent import sample_colors
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.shades import reach_of

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
    assert 1.5 < reach_of(*cells, red()) <= HALF_WAY


@pytest.mark.parametrize('radius', [5, 60])
def test_one_that_is_elsewhere_too_is_not(radius):
    discs = ((100, 100), 33, SHADE), ((100, 100), 30, RED), ((240, 130), radius, SHADE)
    assert reach_of(*picture(*discs), red()) < 1.5


def test_nor_is_one_that_there_is_more_of_than_of_the_thing():
    assert reach_of(*picture(((100, 100), 50, SHADE), ((100, 100), 30, RED)), red()) < 1.5


def test_specks_elsewhere_are_no_things_that_a_shade_may_lie_on():
    discs = [((200 + 6 * k, 40 + 6 * j), 2, SHADE) for k in range(8) for j in range(8)]
    specks = [((200 + 6 * k, 40 + 6 * j), 1, RED) for k in range(8) for j in range(8)]
    thing = ((100, 100), 33, SHADE), ((100, 100), 30, RED)
    assert reach_of(*picture(*discs, *specks, *thing), red()) < 1.5
    assert reach_of(*picture(*specks, *thing), red()) > 1.5


def test_without_a_thing_nothing_is_known():
    assert reach_of(*picture(), red()) is None
    assert reach_of(*picture(((100, 100), 1, RED)), red()) is None


def test_shades_are_found_up_to_the_border_of_the_picture():
    cells = picture(((0, 0), 33, SHADE), ((0, 0), 30, RED), ((319, 239), 30, RED))
    assert reach_of(*cells, red()) > 1.5
