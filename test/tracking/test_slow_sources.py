"""Sources with seconds from one frame to the next, such as radars."""

import numpy as np
import pytest
from support.silhouettes import points

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

PAIRS, FRAMES, MEET, STEP = 6, 44, 30, 10.0
"""Pairs that cross, frames of a run and that in which they meet, and px from one to the next."""


def crossing(k, angle, offset):
    """Places, (2 * PAIRS, 2), in frame k of pairs that cross at an angle [rad]."""
    way = STEP * (k - MEET + offset)
    u, v = 500 + way * np.cos(angle / 2), way * np.sin(angle / 2)
    middle = 100 + 200.0 * np.arange(PAIRS)
    return np.concatenate([np.stack([u, middle + side * v], axis=1) for side in (1, -1)])


def nearest_ids(tracks, place):
    """ID of the published track nearest to each place, (N,)."""
    rows = tracks.rows[tracks.rows['state'] != TENTATIVE]
    away = np.hypot(place[:, :1] - rows['u'], place[:, 1:] - rows['v'])
    return rows['track_id'][away.argmin(axis=1)]


@pytest.mark.slow
@pytest.mark.parametrize('degrees', [20, 40])
@pytest.mark.parametrize('period', [1.0, 2.5, 4.0])
def test_those_that_cross_on_straight_lines_keep_their_ids(period, degrees):
    kept = []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        tracker, before = Tracker(TrackerConfig(image_size=(1000, 1400))), None
        offset = rng.uniform(-0.5, 0.5, PAIRS)
        for k in range(FRAMES):
            place = crossing(k, np.radians(degrees), offset)
            seen = place + rng.normal(0, 1, place.shape)
            tracks = tracker.update(points(seen, round(k * period * NANOSECONDS)))
            if k == MEET - 12:
                before = nearest_ids(tracks, place)
        kept.append(np.mean(nearest_ids(tracks, place) == before))
    assert np.mean(kept) > 0.8


@pytest.mark.parametrize('period', [10.0, 20.0])
def test_however_long_a_frame_takes_its_objects_are_shown_with_one_id_each(period):
    """Eight go straight on, and are missed one time in ten."""
    shown = []
    for seed in range(4):
        rng, ids = np.random.default_rng(seed), set()
        start = np.stack([rng.uniform(300, 700, 8), 100.0 + 100 * np.arange(8)], axis=1)
        step = np.stack([rng.uniform(-5, 5, 8), rng.normal(0, 0.3, 8)], axis=1)
        tracker = Tracker(TrackerConfig(image_size=(1600, 1000), max_dt=100.0))
        for k in range(40):
            seen = (start + step * k + rng.normal(0, 1, start.shape))[rng.random(8) > 0.1]
            rows = tracker.update(points(seen, round((1 + k) * period * NANOSECONDS))).rows
            rows = rows[rows['state'] != TENTATIVE]
            ids.update(rows['track_id'].tolist())
            shown += [len(rows)] if k > 5 else []
        assert len(ids) == 8
    assert np.mean(shown) > 0.999 * 8
