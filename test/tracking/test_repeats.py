"""Films that show pictures twice: nearly the same detections, at later stamps."""

from dataclasses import replace

import numpy as np
import pytest
from support.silhouettes import points
from support.silhouettes import RATE

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

SIZE = (1280, 720)


def stamp(k):
    return round(k * NANOSECONDS / RATE)


def film(seed, repeats, frames=150):
    """Truth (frames, 6, 2) of what bounces at 4 to 9 px a frame, and detections; some repeated."""
    rng = np.random.default_rng(seed)
    angle, speed = rng.uniform(0, 2 * np.pi, 6), rng.uniform(4, 9, 6)
    way = (speed * [np.cos(angle), np.sin(angle)]).T * np.arange(frames)[:, None, None]
    low, size = np.array([40.0, 40.0]), np.array(SIZE) - 80.0
    z = rng.uniform(low, low + size, (6, 2)) - low + way
    truth = low + size - np.abs(np.mod(z, 2 * size) - size)
    found = []
    for k, at in enumerate(truth):
        one = points(at + rng.normal(0, 0.5, at.shape), stamp(k), 0.25, size=(24, 24))
        found.append(again(found[-1], one.stamp, rng) if found and repeats(k) else one)
    return truth, found


def again(last, stamp, rng):
    """The detections of a picture that is repeated, and compressed once more."""
    rows = rng.permutation(last.rows)
    for name in ('u', 'v'):
        rows[name] += rng.normal(0, 0.05, len(rows))
    return replace(last, rows=rows, stamp=stamp)


@pytest.mark.parametrize(
    'repeats',
    [lambda k: k % 3 == 2, lambda k: k % 2 == 1, lambda k: k * 37 % 10 < 2, lambda k: k % 4],
    ids=['17 of 25', '15 of 30', 'now and then', '15 of 60'],
)
@pytest.mark.parametrize('seed', range(3))
def test_objects_go_on_in_repeated_pictures(seed, repeats):
    tracker, held, ids = Tracker(TrackerConfig(image_size=SIZE)), [], {}
    truth, found = film(seed, repeats)
    for k, (at, one) in enumerate(zip(truth, found, strict=True)):
        rows = tracker.update(one).rows
        for n, position in enumerate(at):
            aside = np.array([rows['u'], rows['v']]).T - position
            if k < 20 or not len(rows):
                continue
            near = int(np.hypot(*aside.T).argmin())
            ids.setdefault(n, set()).add(int(rows['track_id'][near]))
            P = rows['covariance'][near][:2, :2]
            held.append(aside[near] @ np.linalg.solve(P, aside[near]) < 5.99)
    assert [len(its) for its in ids.values()] == [1] * 6
    assert np.mean(held) > 0.88, '95 % ellipses, also in the repeated pictures'
    assert tracker.repeats > 0.8 * sum(map(bool, map(repeats, range(20, 150))))


def test_they_are_predictions_that_change_nothing():
    _, found = film(0, lambda k: k in (20, 25, 30))
    one, other = (Tracker(TrackerConfig(image_size=SIZE)) for _ in range(2))
    for k, detections in enumerate(found):
        rows = one.update(detections).rows
        if k == 30:
            assert rows['state'].tolist() == [COASTING] * 6
            assert rows['time_since_update'] == pytest.approx(1 / RATE)
            continue
        assert rows['state'].tolist() == [CONFIRMED] * 6 or k < 3
        assert rows.tobytes() == other.update(detections).rows.tobytes()
    assert (one.repeats, other.repeats) == (1, 0)


@pytest.mark.filterwarnings('error', 'ignore:refused')
def test_numbers_that_are_none_are_refused_as_before():
    tracker = Tracker(TrackerConfig(image_size=SIZE))
    for k, u in enumerate([np.nan, np.inf, -np.inf, -np.inf, 1e308, 1e308, 20.0, 20.0]):
        at = np.array([[20.0, 100.0], [20.0, 200.0], [300.0, 300.0]])
        found = points(at, stamp(k), 1.0, size=(20, 20))
        found.rows['u'][:2] = u, abs(u)
        rows = tracker.update(found).rows
        assert np.isfinite(rows['u']).all()
    assert (len(rows), tracker.repeats) == (3, 0)


def test_what_stands_or_creeps_in_whole_pixels_is_measured():
    tracker = Tracker(TrackerConfig(image_size=SIZE))
    for k in range(120):
        at = np.array([[100.0, 100.0], [300.0 + round(0.3 * k), 200.0]])
        rows = tracker.update(points(at, stamp(k), 1.0, size=(20, 20))).rows
        assert k < 5 or rows['state'].tolist() == [CONFIRMED] * 2
    assert tracker.repeats == 0


def test_what_stops_in_a_repeated_picture_for_good_is_measured_soon():
    """Four pictures on end are more than a film repeats."""
    tracker, repeats = Tracker(TrackerConfig(image_size=SIZE)), (10, 14, 18)
    found = points([[100.0, 300.0]], 0, 0.01, size=(20, 20))
    for k in range(60):
        u = 100 + 7 * min(k, 30)
        if k not in repeats:
            found = points([[u, 300.0]], 0, 0.01, size=(20, 20))
        rows = tracker.update(replace(found, stamp=stamp(k))).rows
    assert rows['state'].tolist() == [CONFIRMED]
    assert rows['u'][0] == pytest.approx(310, abs=1)
    assert np.hypot(rows['du'][0], rows['dv'][0]) < 5
    assert tracker.repeats == 1 + 3
