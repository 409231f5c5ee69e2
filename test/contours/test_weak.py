import numpy as np
import pytest

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.contours.weak import with_weak
from colortrack_ros.data import Frame
from colortrack_ros.data import TENTATIVE

HEAD, COAT, LEGS = np.s_[20:30, 40:50], np.s_[30:60, 40:50], np.s_[60:90, 40:50]


def differences(coat):
    """Strong mask and difference, (120, 160), of a head and legs with a coat between them."""
    difference = np.zeros((120, 160), np.uint8)
    difference[HEAD] = difference[LEGS] = 60
    difference[COAT] = coat
    return (difference > 20).astype(np.uint8), difference


@pytest.mark.parametrize('channels', [1, 3])
def test_a_dark_coat_before_a_dark_wall_joins_head_and_legs(channels):
    strong, difference = differences(coat=15)
    wall = np.full((120, 160, channels), 30, np.uint8)
    mask = with_weak(strong, difference, wall, 20.0, None)
    assert mask[COAT].all()
    assert mask.sum() == (difference > 0).sum()


def test_what_differs_by_less_still_or_little_for_its_light_or_by_itself_is_left_out():
    strong, difference = differences(coat=12)
    wall = np.full((120, 160, 3), 30, np.uint8)
    assert (with_weak(strong, difference, wall, 20.0, None) == strong).all()
    strong, difference = differences(coat=15)  # as a soft shadow on what is bright
    assert (with_weak(strong, difference, np.full_like(wall, 120), 20.0, None) == strong).all()
    difference[100:110, 100:110] = 15
    assert not with_weak(strong, difference, wall, 20.0, None)[100:110, 100:110].any()
    assert not with_weak(np.zeros_like(strong), difference, wall, 20.0, None).any()


def test_what_may_be_left_of_somebody_in_the_background_is_not_joined():
    strong, difference = differences(coat=15)
    wall, settled = np.full((120, 160, 3), 30, np.uint8), np.ones(strong.shape, bool)
    settled[COAT] = False
    assert (with_weak(strong, difference, wall, 20.0, settled) == strong).all()


@pytest.mark.slow
def test_who_wears_a_dark_coat_before_a_dark_wall_is_one_target():
    tracker, live = ContourTracker(ContourConfig()), []
    for k in range(110):
        image = 30 + np.random.default_rng(k).normal(0, 1.5, (240, 320, 3))
        left = 10 + 3 * (k - 45)
        if k >= 45:
            image[60:84, left + 4 : left + 26] = 150
            image[84:144, left : left + 30] = 14
            image[144:200, left + 3 : left + 27] = 110
        frame = Frame(np.clip(image, 0, 255).astype(np.uint8), 'bgr8', round(k * 1e9 / 25))
        rows = tracker.update(frame).rows
        live.append(rows[rows['state'] != TENTATIVE])
    assert [len(rows) for rows in live[-20:]] == [1] * 20
    assert 125 < live[-1]['box_h'][0] < 155
