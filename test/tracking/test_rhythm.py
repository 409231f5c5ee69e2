"""What a detector finds in every second or third frame alone is tracked, and clutter is not."""

import numpy as np
import pytest
from support.silhouettes import points

from colortrack_ros.data import TENTATIVE
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking.rhythm import Rhythm

PLACES = np.array([[100.0, 100.0], [300.0, 110.0], [500.0, 105.0], [200.0, 300.0]])


def pauses(counts):
    rhythm = Rhythm()
    return [rhythm.is_pause(count) for count in counts]


@pytest.mark.parametrize('empty', [1, 2, 4])
def test_empty_frames_that_come_as_usual_are_pauses(empty):
    counts = ([3] + [0] * empty) * 8
    told = pauses(counts)
    since = 3 * (empty + 1) + 1
    assert not any(told[:since])
    assert told[since:] == [count == 0 for count in counts[since:]]


def test_what_comes_less_often_or_not_in_time_is_none():
    assert not any(pauses(([1] + [0] * 5) * 8))
    assert not any(pauses([1, 0, 1, 0, 0] * 8))
    assert not any(pauses([2] * 30 + [0] * 30))
    assert pauses([1, 0] * 5 + [0, 0, 0]) == [False] * 7 + [True, False, True] + [False] * 3


@pytest.mark.parametrize('size', [None, (20, 20)])
@pytest.mark.parametrize('every', [2, 3])
@pytest.mark.parametrize('count', [1, 4])
def test_what_is_seen_in_every_second_or_third_frame_is_tracked(every, count, size):
    rng, tracker, found, names = np.random.default_rng(5), Tracker(), 0, set()
    for k in range(150):
        z = rng.normal(PLACES[:count] + np.array([40 * k / 30, 0]), 1)
        seen = z if k % every == 0 else z[:0]
        tracks = tracker.update(points(seen, round(k / 30 * 1e9), size=size)).rows
        tracks = tracks[tracks['state'] != TENTATIVE]
        names.update(tracks['track_id'].tolist())
        found += len(tracks) * (k >= 30)
    assert found == 120 * count
    assert len(names) == count


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(4))
def test_rare_clutter_is_no_track(seed):
    rng, tracker, shown = np.random.default_rng(seed), Tracker(), 0
    for k in range(600):
        seen = rng.uniform(0, (640, 480), (rng.poisson(0.3), 2))
        shown += (
            tracker.update(points(seen, round(k / 30 * 1e9))).rows['state'] != TENTATIVE
        ).sum()
    assert shown == 0


@pytest.mark.parametrize('size', [None, (20, 20)])
def test_what_a_second_detector_finds_in_the_pauses_of_the_first_is_tracked(size):
    """Its messages have the stamps of the empty ones of the first."""
    rng, tracker, found, names = np.random.default_rng(6), Tracker(), 0, set()
    for k in range(150):
        stamp, z = round(k / 30 * 1e9), rng.normal(PLACES + np.array([40 * k / 30, 0]), 1)
        seen = (z, z[:0]) if k % 2 == 0 else (z[:0], z)
        for each in seen:
            tracks = tracker.update(points(each, stamp, size=size)).rows
        tracks = tracks[tracks['state'] != TENTATIVE]
        names.update(tracks['track_id'].tolist())
        found += len(tracks) * (k >= 30)
    assert found == 120 * len(PLACES)
    assert len(names) == len(PLACES)
