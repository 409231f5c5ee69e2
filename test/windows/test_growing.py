"""Targets that come near or go away."""

import cv2
import numpy as np
import pytest
from support.window_pictures import frame
from support.window_pictures import texture

from colortrack_ros.data import CONFIRMED
from colortrack_ros.windows import WindowTracker
from colortrack_ros.windows.config import LEAST_SIDE
from colortrack_ros.windows.scale import ScaleFilter

WALL = texture(40, 480, 640, cell=4.0)
MIDDLE = np.array([320.0, 240.0])


def shown(look, side, center=MIDDLE):
    """The wall with a look as large as that around a center."""
    count = max(int(len(look) / side), 1)  # means of as many pixels on each axis
    small = cv2.resize(look, None, fx=1 / count, fy=1 / count, interpolation=cv2.INTER_AREA)
    step = side / len(small)
    shift = center - step * (len(small) - 1) / 2
    matrix = np.array([[step, 0, shift[0]], [0, step, shift[1]]])
    place = [
        cv2.warpAffine(picture, matrix, WALL.shape[::-1], flags=cv2.INTER_LINEAR)
        for picture in (small, np.ones_like(small))
    ]
    return WALL * (1 - place[1]) + place[0]


def boxed(center, side):
    return [*(center - (side - 1) / 2), side, side]


@pytest.mark.slow
@pytest.mark.parametrize(('first', 'growth'), [(32, 1.02), (240, 1 / 1.02)])
def test_what_grows_or_shrinks_steadily_keeps_its_box(first, growth):
    """Seven times; before, boxes ended at five times, and a fifth, and windows lost them."""
    look = texture(41, 512, 512, cell=16.0) + texture(42, 512, 512, cell=60.0) - 128
    tracker = WindowTracker(targets=[boxed(MIDDLE, first)])
    for k in range(100):
        side, center = first * growth**k, np.add(MIDDLE, (0.5 * k, -0.3 * k))
        if side < 16:
            break
        (row,) = tracker.update(frame(shown(look, side, center), k, 30.0)).rows
        assert row['state'] == CONFIRMED
        assert row['box_w'] == pytest.approx(side, rel=0.2)
        assert np.hypot(*(center - (row['u'], row['v']))) < 0.05 * side + 0.5


@pytest.mark.parametrize(('wanted', 'told'), [(0.01, LEAST_SIDE / 24), (2.5, 2.5), (50.0, 16.0)])
def test_a_size_ends_at_that_of_a_window_and_at_that_of_the_picture(wanted, told):
    picture = frame(WALL)
    sizes = ScaleFilter(picture, MIDDLE, np.array([40.0, 24.0]))
    sizes.set(picture, wanted)
    assert sizes.scale == pytest.approx(told)
