import numpy as np
import pytest
from support.contour_pictures import frame
from support.contour_pictures import picture
from support.contour_pictures import texture

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.contours.shadows import without_shadows

BODY, OTHER, STRIP = np.s_[40:160, 100:130], np.s_[50:160, 240:270], np.s_[145:160, 130:240]


def ground(channels=3):
    """Paving, (240, 320, channels) [levels]."""
    bricks = 160 + 0.5 * (texture(3, contrast=60.0, cell=4.0) - 128)
    return np.repeat(bricks[..., None], channels, axis=2).clip(0, 255).astype(np.uint8)


def scene(*parts, channels=3, before=None):
    """A picture, its background, and the mask of parts, each a slice and what it shows.

    What it shows is a level, or a share of the light if below 1.
    """
    background = ground(channels) if before is None else before
    image, mask = background.copy(), np.zeros(background.shape[:2], np.uint8)
    for where, shows in parts:
        image[where] = background[where] * shows if shows < 1 else shows
        mask[where] = 255
    return mask, image, background


def box(mask):
    rows, columns = np.nonzero(mask)
    return [columns.min(), rows.min(), columns.max(), rows.max()]


@pytest.mark.parametrize('light', [0.2, 0.5, 0.8])
def test_the_shadow_beside_a_body_is_cut_off(light):
    mask, image, background = scene((BODY, 30), (STRIP, light))
    assert box(without_shadows(mask, image, background, 50, 20.0)) == [100, 40, 129, 159]


def test_a_shadow_is_bluer_than_the_ground():
    mask, image, background = scene((BODY, 30), (STRIP, 0.2))
    image[STRIP] = (background[STRIP] * [0.24, 0.21, 0.2]).astype(np.uint8)
    assert box(without_shadows(mask, image, background, 50, 20.0)) == [100, 40, 129, 159]


def test_bodies_that_a_shadow_joins_are_two():
    mask, image, background = scene((BODY, 30), (OTHER, 220), (STRIP, 0.3))
    left = without_shadows(mask, image, background, 50, 20.0)
    assert not left[:, 130:240].any()
    assert (left[BODY] == 255).all()
    assert (left[OTHER] == 255).all()


@pytest.mark.parametrize('shows', [12, 110, 250])
def test_what_is_low_and_no_dimmed_background_stays(shows):
    mask, image, background = scene((BODY, 30), (STRIP, shows))
    if shows == 110:
        image[STRIP] = [20, 110, 200]
    assert (without_shadows(mask, image, background, 50, 20.0) == mask).all()


def test_gray_clothes_before_a_plain_gray_wall_stay():
    wall = np.full((240, 320, 3), 150, np.uint8)
    foot = np.s_[145:160, 130:150]  # of a leg that strides
    mask, image, background = scene((BODY, 0.5), (foot, 0.5), before=wall)
    assert (without_shadows(mask, image, background, 50, 20.0) == mask).all()


def test_the_rim_that_the_gaussian_adds_does_not_count():
    mask, image, background = scene((BODY, 30), (STRIP, 0.3))
    mask[135:170, 130:240] = 255  # more of it is background as it was than is dimmed
    assert box(without_shadows(mask, image, background, 50, 20.0))[2] == 129


def test_without_colors_nothing_is_told_from_a_shadow():
    mask, image, background = scene((BODY, 30), (STRIP, 0.3), channels=1)
    assert (without_shadows(mask, image, background, 50, 20.0) == mask).all()


def test_what_is_above_the_middle_lies_on_no_ground():
    arm = np.s_[60:75, 130:240]
    mask, image, background = scene((BODY, 30), (arm, 0.3))
    assert (without_shadows(mask, image, background, 50, 20.0) == mask).all()


def test_small_areas_and_empty_masks_are_left_as_they_are():
    mask, image, background = scene((BODY, 30), (STRIP, 0.3))
    assert (without_shadows(mask, image, background, 10_000, 20.0) == mask).all()
    assert not without_shadows(np.zeros_like(mask), image, background, 50, 20.0).any()


@pytest.mark.slow
def test_who_walks_in_the_sun_has_the_box_of_a_body():
    tracker, wall = ContourTracker(ContourConfig(learn_seconds=0.5)), ground()
    for k in range(60):
        center = (60.0 + 2.5 * (k - 20), 120.0) if k >= 20 else None
        gray = picture('person', center, 26.0, background=wall[..., 0].astype(float), seed=k)
        image = np.repeat(gray[..., None], 3, axis=2)
        if center is not None:
            feet = np.nonzero(np.abs(gray.astype(int) - wall[..., 0]) > 60)[0].max()
            end = int(center[0]) + 15
            strip = np.s_[feet - 8 : feet + 1, end : end + 110]
            image[strip] = np.minimum(image[strip], (wall[strip] * 0.35).astype(np.uint8))
        tracks = tracker.update(frame(image, k))
    assert len(tracks.rows) == 1
    low, high = tracks.outlines[0].min(axis=0), tracks.outlines[0].max(axis=0)
    assert high[0] - low[0] < 60
    assert abs((low[0] + high[0]) / 2 - center[0]) < 12
