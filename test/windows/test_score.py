"""The score of a target: how much what was found resembles it."""

import numpy as np
from support.window_pictures import frame
from support.window_pictures import texture

from colortrack_ros.data import CONFIRMED
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker


def test_what_is_followed_by_its_appearance_alone_has_the_score_of_that():
    """Its score was 0 if its template was never found, so that min_score left it out."""
    look, wall = texture(31, 31, 31), 0.4 * texture(30, 240, 320) + 70
    tracker = WindowTracker(WindowConfig(min_similarity=1.0), [[45, 45, 31, 31]])
    for k in range(20):
        picture = wall.astype(np.float32)
        place = picture[45 + k : 76 + k, 45 + 3 * k : 76 + 3 * k]
        place[:] = look + 8 * np.random.default_rng(k).normal(size=look.shape)
        (row,) = tracker.update(frame(picture, k)).rows
        assert row['state'] == CONFIRMED
        assert 0.5 < row['score'] <= 1
