from itertools import pairwise

import cv2
import numpy as np
import pytest
from support.contour_pictures import follow
from support.contour_pictures import frame
from support.contour_pictures import picture

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours.background import KNOWN_SECONDS
from colortrack_ros.contours.background import LAST_LOOK
from colortrack_ros.contours.background import StillBackground
from colortrack_ros.contours.background import Stillness
from colortrack_ros.contours.foreground import Foreground
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.label_image import LabelImage

PERIOD = 40_000_000


def shown(level, channels=3):
    """A picture of one level but for its noise."""
    noise = np.random.default_rng(int(level)).integers(-2, 3, (20, 30, channels))
    return (level + noise).astype(np.uint8)


def learned(levels, channels=3, learn_seconds=1.5):
    """The background of pictures of such levels."""
    background, image = StillBackground(), LabelImage.empty(20, 30)
    image.pixels[:] = 0
    for k, level in enumerate(levels):
        none = find_blobs(image, 1)
        background.follow(shown(level, channels), k * PERIOD, none, learn_seconds)
    return background


@pytest.mark.parametrize('channels', [1, 3])
def test_what_stood_still_longest_is_background_though_most_pictures_show_something_else(channels):
    walkers = [40, 60, 80, 100, 120, 140, 160]
    levels = [level for walker in walkers for level in [walker] * 4 + [200] * 2] + [200] * 10
    background = learned(levels, channels)
    assert abs(np.median(background.recent) - 200) <= 2
    assert background.recent.shape == (20, 30, channels)


def test_the_edges_of_what_leaves_and_comes_are_not_in_it():
    stillness, picture = Stillness(shown(80), 0), shown(80)
    for k, level in enumerate([80, 80, 193, *[200] * 9, 193, 80], 1):
        new = stillness.look(shown(level), 3 * k * PERIOD, 1.5, picture)
        cv2.copyTo(stillness.value, new, picture)
    assert abs(np.median(picture) - 200) <= 1


def wall_and_thing(left):
    """A gray wall, before it a plain thing of 20 by 24 pixels from a column on, None for none."""
    image = np.random.default_rng(0).integers(96, 105, (40, 80, 3)).astype(np.uint8)
    if left is not None:
        image[8:32, left : left + 20] = 200
    return image


@pytest.mark.parametrize(
    'ways',
    [
        [None] * 20 + [10 + k // 4 for k in range(75)],  # comes, and goes on slowly
        [10] * 20 + [None] * 60,  # there from the start, and gone at once
    ],
)
def test_the_middle_of_what_comes_slowly_is_not_background_and_what_is_uncovered_is(ways):
    background = wall_and_thing(ways[0])
    stillness = Stillness(background.copy(), 0)
    for k, left in enumerate(ways[1:], 1):
        shown = wall_and_thing(left)
        cv2.copyTo(stillness.value, stillness.look(shown, k * PERIOD, 1.0, background), background)
    assert (background < 150).all()


def test_a_place_is_known_when_something_has_stood_still_there():
    frames = round(KNOWN_SECONDS * 1e9 / PERIOD)
    assert learned([200]).unknown().all()
    assert learned([200] * frames).unknown().all()
    assert not learned([200] * (frames + 5)).unknown().any()
    flickers = learned(list(range(50, 250, 40)) * 10)
    assert flickers.unknown().all()


def test_what_flickers_for_ever_is_given_up_and_the_first_picture_is_all_without_learning():
    count = round(LAST_LOOK * 1e9 / PERIOD) + 10
    assert learned(list(range(50, 250, 40)) * (count // 5)).unknown() is None
    assert learned([200], learn_seconds=0.0).unknown() is None


def test_stamps_that_go_back_do_no_harm():
    stillness = Stillness(shown(200), 10 * PERIOD)
    for k in (20, 5, 8, 11, 14):
        stillness.look(shown(200), k * PERIOD, 1.5, shown(200))
    assert (stillness.longest > 0).all()


@pytest.mark.slow
def test_of_what_is_seen_in_parts_at_first_one_target_is_left():
    def seen(k):
        belt = (np.s_[118:134], 215) if k < 18 else None
        return picture('person', (20.0 + 3 * k, 120.0), 30, cover=belt, seed=k)

    empty = [picture('person', None, 0.0, seed=k) for k in range(6)]
    results = follow(empty + [seen(k) for k in range(60)], ContourConfig(learn_seconds=0.0))
    assert max(len(tracks.rows) for tracks in results[:24]) > 1
    assert len(results[-1].rows) == 1
    assert abs(results[-1].rows['u'][0] - 197) < 6


@pytest.mark.parametrize(('rate', 'share'), [(5.0, 0.0), (15.0, 0.5), (24.0, 1 / 3)])
def test_other_work_waits_for_a_frame_while_the_background_is_looked_at(rate, share):
    foreground, busy = Foreground(ContourConfig(learn_seconds=5.0)), []
    for k in range(25):
        image = picture('person', (60.0 + 5 * k, 120.0), 20.0)
        foreground.areas(frame(image, k, rate), np.zeros((0, 4)))
        busy.append(foreground.is_busy)
    assert np.mean(busy[1:]) == pytest.approx(share, abs=0.05)
    assert not any(a and b for a, b in pairwise(busy))


def test_what_comes_slowly_soon_after_the_start_is_no_part_of_the_background():
    background, image = StillBackground(), LabelImage.empty(120, 160)
    image.pixels[:] = 0
    for k in range(72):
        wall = np.full((120, 160, 1), 200, np.uint8)
        if k > 8:
            left = 60 + round(15 * np.sin(k / 20))
            wall[40:80, left : left + 40] = 50
        background.follow(wall, round(k * 1e9 / 24), find_blobs(image, 1), 1.5)
    _, lasting = background.pictures
    assert (lasting > 150).all()
