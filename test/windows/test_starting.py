"""Boxes that show nothing which could be followed."""

import numpy as np
import pytest
from support.window_pictures import frame

from colortrack_ros.data import Frame
from colortrack_ros.windows import WindowTracker


@pytest.mark.parametrize('channels', [1, 3])
def test_what_nothing_tells_from_its_surroundings_is_refused_and_counted(channels):
    plain, spotted = np.full((2, 240, 320, channels), 90, np.uint8)
    spotted[100:120, 150:180] = 200
    encoding = 'bgr8' if channels == 3 else 'mono8'
    for image, count in ((plain, 0), (spotted, 1)):
        tracker = WindowTracker(targets=[[150, 100, 30, 20]])
        tracks = tracker.update(Frame(image, encoding, 0))
        assert (len(tracks.rows), tracker.waiting.refused) == (count, 1 - count)


def test_a_wall_is_refused_for_all_its_noise_and_light_and_what_is_faint_on_it_is_not():
    """Before, a window on a wall went off to whatever came nearest to it."""
    wall = np.linspace(90, 120, 320) + np.linspace(0, 20, 240)[:, None]
    wall += np.random.default_rng(3).normal(0, 2.5, wall.shape)
    marked = wall.copy()
    marked[100:120, 150:180] += 12
    for picture, count in ((wall, 0), (marked, 1)):
        tracker = WindowTracker(targets=[[150, 100, 30, 20]])
        assert (len(tracker.update(frame(picture, 0)).rows), tracker.waiting.refused) == (
            count, 1 - count,
        )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize('side', [24, 27, 29])
def test_a_box_inside_a_drawn_square_neither_shrinks_nor_leaves_the_middle(side):
    """It shows one color alone; before, it shrank to a quarter and went to the edge."""
    tracker = WindowTracker(targets=[[60 - side / 2 + 0.5, 60 - side / 2 + 0.5, side, side]])
    for k in range(40):
        picture = np.full((240, 320, 3), 255, np.uint8)
        picture[45 + k : 76 + k, 45 + 3 * k : 76 + 3 * k] = 0, 0, 255
        (row,) = tracker.update(Frame(picture, 'bgr8', round(k * 1e9 / 30))).rows
        assert np.hypot(row['u'] - 60 - 3 * k, row['v'] - 60 - k) < 2
    assert row['box_w'] == pytest.approx(side, rel=0.1)
