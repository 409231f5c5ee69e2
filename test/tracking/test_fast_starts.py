"""An object faster than any before is found by three detections on a line."""

import numpy as np
import pytest
from support.silhouettes import message
from support.silhouettes import points
from support.silhouettes import RATE

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking import Tracker


def standing(tracker, frames, rng):
    places = np.stack([np.full(6, 150.0), 80 + 100.0 * np.arange(6)], axis=1)
    for k in range(frames):
        tracker.update(message(places + rng.normal(0, 1, places.shape), k))
    return places


def test_what_stands_and_dashes_off_keeps_its_id():
    rng, tracker = np.random.default_rng(0), Tracker()
    places = standing(tracker, 60, rng)
    way = np.cumsum([10, 20, 30, *[40.0] * 9, 30, 20, 10, *[0] * 20])
    for k, s in enumerate(way):
        z = places + np.outer(np.arange(6) == 2, [s, 0.0])
        rows = tracker.update(message(z + rng.normal(0, 1, z.shape), 60 + k)).rows
        if k >= 7:
            assert rows['track_id'][rows['state'] == 1].tolist() == [1, 2, 3, 4, 5, 6]
            assert abs(rows['u'][2] - z[2, 0]) < 15


def test_a_fast_newcomer_is_published_with_its_velocity_at_the_third_detection():
    rng, tracker = np.random.default_rng(0), Tracker()
    places = standing(tracker, 60, rng)
    for k in range(3):
        z = np.append(places, [[1000.0 - 45 * k, 330 + 20 * k]], axis=0)
        rows = tracker.update(message(z + rng.normal(0, 1, z.shape), 60 + k)).rows
    new = rows[rows['track_id'] > 6]
    new = new[new['state'] == 1]
    assert len(new) == 1
    error = np.array([new['du'][0] + 45 * RATE, new['dv'][0] - 20 * RATE])
    assert error @ np.linalg.solve(new['covariance'][0, 2:, 2:], error) < 13.8


def test_one_line_of_false_detections_makes_no_other_object_fast():
    """A missed object at rest is as certain as without the line."""
    sigma = []
    for line in (False, True):
        rng, tracker = np.random.default_rng(0), Tracker()
        places = standing(tracker, 60, rng)
        for k in range(6):
            seen = (places + rng.normal(0, 1, places.shape))[k > 2 :]
            if line and k < 3:
                seen = np.append(seen, [[1200.0 - 240 * k, 700 - 90 * k]], axis=0)
            rows = tracker.update(message(seen, 60 + k)).rows
        missed = rows[rows['track_id'] == 1]
        sigma.append(np.sqrt(missed['covariance'][0, 0, 0]))
    assert sigma[1] < 1.2 * sigma[0]


def test_three_colors_are_no_line():
    rng, tracker = np.random.default_rng(0), Tracker()
    places = standing(tracker, 60, rng)
    for k in range(3):
        z = np.append(places, [[1000.0 - 45 * k, 330]], axis=0)
        rows = tracker.update(message(z, 60 + k, [0] * 6 + [k + 1])).rows
    assert np.count_nonzero(rows['state'] == 1) == 6


@pytest.mark.parametrize(
    ('turn', 'sizes'), [(0, [20, 20, 20]), (45, [20, 20, 20]), (0, [20, 20, 60])]
)
def test_three_that_bend_or_differ_in_size_are_no_line(turn, sizes):
    rng, tracker = np.random.default_rng(0), Tracker()
    places, angle = standing(tracker, 60, rng), np.radians(turn)
    way = 60 * np.cumsum([[0, 0], [1, 0], [np.cos(angle), np.sin(angle)]], axis=0)
    for k in range(3):
        z = np.append(places, [[600, 330] + way[k]], axis=0)
        z += rng.normal(0, 1, z.shape)
        stamp, size = (60 + k) * NANOSECONDS // RATE, np.array([20] * 6 + [sizes[k]])[:, None]
        rows = tracker.update(points(z, stamp, 1.0, size=size)).rows
    is_line = turn == 0 and len(set(sizes)) == 1
    assert np.count_nonzero(rows['state'] == 1) == 6 + is_line


@pytest.mark.slow
def test_clutter_makes_no_fast_objects():
    rng, tracker = np.random.default_rng(0), Tracker()
    places, false = standing(tracker, 30, rng), 0
    for k in range(150):
        z = np.concatenate([places, rng.uniform((250, 0), (1280, 720), (rng.poisson(20), 2))])
        rows = tracker.update(message(z + rng.normal(0, 1, z.shape), 30 + k)).rows
        false += np.count_nonzero((rows['state'] > 0) & (rows['u'] > 250))
    assert false < 30
