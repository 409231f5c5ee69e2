import numpy as np
import pytest
from support.contour_pictures import frame
from support.contour_pictures import picture
from support.contour_pictures import texture

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.contours.areas import Areas
from colortrack_ros.contours.areas import find_areas
from colortrack_ros.contours.displaced import is_displaced
from colortrack_ros.contours.displaced import MOVE_REACH

LEAVES = texture(5, contrast=60.0, cell=1.0).astype(np.uint8)[..., None]
NOBODY = np.zeros((0, 4))


def areas_of(mask):
    return find_areas(mask.astype(np.uint8), 50, NOBODY)


@pytest.mark.parametrize('step', [(0, 1), (-MOVE_REACH, 0), (MOVE_REACH, -MOVE_REACH)])
@pytest.mark.parametrize('channels', [1, 3])
def test_background_that_has_moved_by_a_little_is_told_from_what_was_nowhere_near(step, channels):
    background = np.repeat(LEAVES, channels, axis=2)
    image = background.copy()
    image[40:80, 50:90] = np.roll(background, step, axis=(0, 1))[40:80, 50:90]
    image[40:80, 200:240] = np.random.default_rng(1).integers(0, 40, (40, 40, channels))
    mask = np.zeros(image.shape[:2], bool)
    mask[40:80, 50:90] = mask[40:80, 200:240] = True
    assert is_displaced(areas_of(mask), image, background, 20.0).tolist() == [True, False]


def test_what_is_farther_off_than_the_reach_is_not_background():
    leaves = [texture(k, contrast=60.0, cell=1.0) for k in range(3)]
    background = np.stack(leaves, axis=2).astype(np.uint8)
    image = background.copy()
    image[40:80, 50:90] = np.roll(background, 40, axis=1)[40:80, 50:90]
    mask = np.zeros(image.shape[:2], bool)
    mask[40:80, 50:90] = True
    assert not is_displaced(areas_of(mask), image, background, 20.0).any()


def test_the_corners_of_the_picture_and_no_areas_do_no_harm():
    mask = np.ones(LEAVES.shape[:2], bool)
    assert not is_displaced(areas_of(mask), LEAVES, LEAVES, 20.0).any()
    assert is_displaced(Areas.none(), LEAVES, LEAVES, 20.0).tolist() == []


@pytest.mark.slow
def test_leaves_in_the_wind_are_no_targets_and_who_walks_before_them_is_one():
    tracker, ids = ContourTracker(ContourConfig(learn_seconds=0.5)), set()
    for k in range(90):
        wind = round(1.5 * np.sin(k / 2)), round(2 * np.sin(k / 3))
        wall = np.full((240, 320), 215.0)
        wall[:100, 40:160] = np.roll(LEAVES[..., 0], wind, axis=(0, 1))[:100, 40:160]
        center = (20.0 + 2.5 * (k - 20), 150.0) if k >= 20 else None
        tracks = tracker.update(frame(picture('person', center, 26.0, background=wall, seed=k), k))
        ids |= set(tracks.rows['track_id'][tracks.rows['state'] > 0].tolist())
    assert len(ids) == 1
    assert len(tracks.rows) == 1
