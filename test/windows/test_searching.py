"""Targets that are looked for where they are not expected."""

import numpy as np
from support.window_pictures import frame
from support.window_pictures import texture

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker

WALL = 0.4 * texture(30, 240, 320) + 70


def shown(u, v):
    """The wall with the target around a center."""
    picture = WALL.copy()
    picture[v - 15 : v + 16, u - 15 : u + 16] = texture(34, 31, 31)
    return picture


def test_near_its_last_place_a_target_has_to_be_no_more_like_itself_after_a_long_search():
    """After 100 looks no place would be like enough if all of them were counted."""
    states, config = [], WindowConfig(max_time_since_update=9.0)
    tracker = WindowTracker(config, [45, 45, 31, 31])
    for k in range(10):
        tracker.update(frame(shown(60, 60) if k < 9 else WALL, k))
    tracker._tracks.records['looks'] = 127
    for k in range(10, 26):
        (row,) = tracker.update(frame(shown(132, 62), k)).rows
        states.append(row['state'])
    assert (states[0], states[-1]) == (COASTING, CONFIRMED)
    assert np.hypot(row['u'] - 132, row['v'] - 62) < 2
