"""An object that is reported twice in a frame is one object."""

import numpy as np
import pytest
from support.silhouettes import points
from support.silhouettes import RATE

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

FRAMES, SIDE = 90, 40.0


def reported(random, center, jitter, twice):
    """Centers and sizes of the boxes of a frame: sides are off by so much [px]."""
    center = np.concatenate([center, center[random.random(len(center)) < twice]])
    low, high = (side * SIDE / 2 + random.normal(0, jitter, center.shape) for side in (-1, 1))
    order = random.permutation(len(center))
    return (center + (low + high) / 2)[order], (high - low)[order]


@pytest.mark.parametrize('twice', [0.2, 0.5, 1.0])
@pytest.mark.parametrize('jitter', [0.5, 1.0])
@pytest.mark.parametrize('count', [1, 5])
def test_what_is_found_twice_has_one_track(count, jitter, twice):
    random, tracker, seen = np.random.default_rng(0), Tracker(), []
    start, speed = np.array([[150.0, 150.0 * n] for n in range(count)]), np.array([60.0, 15.0])
    for k in range(FRAMES):
        z, size = reported(random, start + speed * k / RATE, jitter, twice)
        rows = tracker.update(points(z, round(k * NANOSECONDS / RATE), 0.0, size=size)).rows
        seen += [set(rows['track_id'][rows['state'] > 0])]
    assert seen[-1] == set.union(*seen)
    assert len(seen[-1]) == count


def test_two_that_pass_in_boxes_that_coincide_keep_their_tracks():
    tracker, ids = Tracker(), []
    for k in range(FRAMES):
        way = 3.0 * (k - 45)
        z = np.array([[300 + way, 200.0], [300 - way, 206.0]])
        z += np.random.default_rng(k).normal(0, 1, z.shape)
        rows = tracker.update(points(z, round(k * NANOSECONDS / RATE), 1.0, size=(40, 40))).rows
        ids += [rows['track_id'][rows['u'].argsort()].tolist()]
    assert ids[20] == ids[-1][::-1]
    assert len(ids[20]) == 2


@pytest.mark.parametrize(('twice', 'apart', 'count'), [(0.2, 0.3, 6), (0.5, 1.4, 1), (1.0, 0.3, 6)])
def test_points_found_twice_have_one_track(twice, apart, count):
    random, tracker, seen = np.random.default_rng(1), Tracker(), []
    start = np.array([[150.0, 100.0 * n] for n in range(count)])
    for k in range(FRAMES):
        z = start + np.array([60.0, 15.0]) * k / RATE + random.normal(0, 1, start.shape)
        again = z[random.random(count) < twice]
        z = np.concatenate([z, again + random.normal(0, apart, again.shape)])
        rows = tracker.update(
            points(random.permutation(z), round(k * NANOSECONDS / RATE), 0.0)
        ).rows
        seen += [set(rows['track_id'][rows['state'] > 0])]
    assert seen[-1] == set.union(*seen)
    assert len(seen[-1]) == count


def test_a_point_that_is_missed_does_not_take_its_neighbor_found_twice():
    random, tracker = np.random.default_rng(0), Tracker()
    for k in range(FRAMES):
        z = np.array([[100.0 + 3 * k, 300.0], [100.0 + 3 * k, 320.0]])
        z += random.normal(0, 1, z.shape)
        again = z[:1] + random.normal(0, 0.3, (1, 2))
        z = np.concatenate([z[: 1 + (k % 10 < 9)], again])
        rows = tracker.update(points(z, round(k * NANOSECONDS / RATE), 1.0)).rows
        if k > 10:
            assert np.abs(rows['v'] - [300, 320]).max() < 6


@pytest.mark.parametrize('apart', [3.5, 5.0])
def test_a_second_point_that_comes_near_another_has_a_track_of_its_own(apart):
    random, tracker = np.random.default_rng(0), Tracker()
    for k in range(FRAMES):
        z = np.array([[100.0 + 3 * k, 300.0], [100.0 + 3 * k, 300.0 + apart]])
        z = z[: 1 + (k > 30)]
        z += random.normal(0, 1, z.shape)
        rows = tracker.update(points(z, round(k * NANOSECONDS / RATE), 1.0)).rows
    assert np.count_nonzero(rows['state'] > 0) == 2


@pytest.mark.parametrize(('gates', 'count'), [(False, 1), (True, 2)])
def test_one_thing_whose_label_flips_has_one_track_where_colors_do_not_gate(gates, count):
    random, tracker = np.random.default_rng(0), Tracker(TrackerConfig(color_gating=gates))
    for k in range(FRAMES):
        z = random.normal((150.0 + 2 * k, 200.0), 1, (1, 2))
        color = int(random.random() < 0.5)
        stamp = round(k * NANOSECONDS / RATE)
        rows = tracker.update(points(z, stamp, color=color, size=(40, 40))).rows
    assert np.count_nonzero(rows['state'] > 0) == count
