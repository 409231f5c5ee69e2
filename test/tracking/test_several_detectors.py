"""Two detectors on one topic that find the same objects: each object has one track."""

from dataclasses import replace

import numpy as np
import pytest
from support.silhouettes import lasting
from support.silhouettes import points

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

FRAMES, RATE, SIDE = 150, 30, 30.0
START = np.array([[100.0, 100.0], [300.0, 150.0], [500.0, 380.0]])
SPEED = np.array([[60.0, 20.0], [-40.0, 30.0], [-20.0, -60.0]])


def way(k):
    return START + SPEED * k / RATE


def blobs(k, rng):
    """As a color detector finds them, in boxes of whole pixels that fit."""
    z = way(k) + rng.normal(0, 0.3, START.shape)
    return points(z, round(k / RATE * NANOSECONDS), 0.09, size=(SIDE, SIDE))


def boxes(k, rng, error, scale=1.0):
    """As a network does, that says nothing about errors; one in ten is missed."""
    z = way(k) + error[k]
    size = (scale * SIDE + 4) * rng.lognormal(0, 0.05, START.shape)
    found = points(z, round(k / RATE * NANOSECONDS), size=size)
    found.rows['score'] = rng.uniform(0.4, 0.99, len(z))
    return replace(found, rows=found.rows[rng.random(len(z)) > 0.1])


def in_one_message(tracker, found, others):
    rows = np.concatenate([others.rows, found.rows])
    return tracker.update(replace(found, rows=rows)).rows


def one_after_the_other(tracker, found, others):
    tracker.update(found)
    return tracker.update(others).rows


@pytest.mark.slow
@pytest.mark.parametrize(
    ('give', 'scale', 'joins'),
    [
        (in_one_message, 1.0, 0), (in_one_message, 1.5, 60),
        (one_after_the_other, 1.5, 0), (one_after_the_other, 1.0, 60),
    ],
)  # fmt: skip
def test_an_object_that_two_detectors_find_has_one_track_as_exact_as_by_the_better(
    give, scale, joins
):
    """Also if the second one joins later."""
    rng, tracker = np.random.default_rng(0), Tracker()
    error = 1.9 * lasting(rng, (FRAMES, *START.shape), 0.9)
    for k in range(FRAMES):
        others = boxes(k, rng, error, scale)
        if k < joins:
            others = replace(others, rows=others.rows[:0])
        rows = give(tracker, blobs(k, rng), others)
        assert rows['track_id'].max() <= len(START)
        if k > 30:
            assert np.abs(np.stack([rows['u'], rows['v']], axis=1) - way(k)).max() < 1.5


def test_what_only_the_second_detector_finds_has_a_track():
    rng, tracker = np.random.default_rng(0), Tracker()
    for k in range(30):
        found, stamp = blobs(k, rng), round(k / RATE * NANOSECONDS)
        other = points([[400.0, 300.0]], stamp, size=(SIDE, SIDE))
        rows = one_after_the_other(tracker, found, other)
    assert len(rows) == len(START) + 1


@pytest.mark.parametrize(('size', 'apart'), [((30, 30), 12.0), (None, 12.0)])
def test_two_objects_of_which_each_detector_finds_one_have_two_tracks(size, apart):
    rng, tracker = np.random.default_rng(0), Tracker()
    for k in range(60):
        z, stamp = np.array([[100.0 + 2 * k, 200.0]]), round(k / RATE * NANOSECONDS)
        found, other = (
            points(z + np.array([0, dv]) + rng.normal(0, 0.5, (1, 2)), stamp, 0.25, size=size)
            for dv in (0, apart)
        )
        rows = one_after_the_other(tracker, found, other)
    np.testing.assert_allclose(np.sort(rows['v']), [200, 200 + apart], atol=1.5)


def test_points_of_two_detectors_have_one_track():
    rng, tracker = np.random.default_rng(0), Tracker()
    for k in range(60):
        z, stamp = way(k), round(k / RATE * NANOSECONDS)
        found, other = (points(z + rng.normal(0, 1, z.shape), stamp, 1.0) for _ in range(2))
        rows = one_after_the_other(tracker, found, other)
    assert rows['track_id'].tolist() == [1, 2, 3]


def test_what_lies_on_another_and_is_much_smaller_or_of_another_color_has_a_track():
    tracker = Tracker()
    for k in range(60):
        z, stamp = way(k), round(k / RATE * NANOSECONDS)
        tracker.update(points(z, stamp, 0.25, size=(SIDE, SIDE)))
        held = points(z[:1], stamp, size=(10, 10))
        other = points(z[1:2], stamp, color=1, size=(SIDE, SIDE))
        rows = tracker.update(replace(held, rows=np.concatenate([held.rows, other.rows]))).rows
    assert len(rows) == len(START) + 2


@pytest.mark.slow
@pytest.mark.parametrize('size', [(), (20.0, 20.0)])
def test_a_detector_that_states_some_covariances_tracks_as_one_that_states_all(size):
    rng, tracker, error = np.random.default_rng(0), Tracker(), []
    side = {'size': size} if size else {}
    for k in range(FRAMES):
        z, stamp = way(k) + rng.normal(0, 1, START.shape), round(k / RATE * NANOSECONDS)
        found = points(z, stamp, 1.0, **side)
        for name in ('cov_uu', 'cov_vv'):
            found.rows[name][k % 3] = 0
        rows = tracker.update(found).rows
        if k > 30:
            error.append(np.stack([rows['u'], rows['v']], axis=1) - way(k))
    assert rows['track_id'].tolist() == [1, 2, 3]
    assert np.sqrt(np.square(error).mean()) < 1.0


@pytest.mark.filterwarnings('ignore:refused')
def test_rows_that_are_no_numbers_are_refused_as_ever_when_others_state_no_covariance():
    tracker = Tracker()
    for k in range(10):
        stamp = round(k / RATE * NANOSECONDS)
        found = points(way(k), stamp, 0.25, size=(SIDE, SIDE))
        bad = points(way(k), stamp, size=(SIDE, SIDE)).rows
        bad['cov_uu'][0], bad['u'][1], bad['box_w'][2] = np.nan, np.inf, np.nan
        rows = in_one_message(tracker, found, replace(found, rows=bad))
    assert rows['track_id'].tolist() == [1, 2, 3]
    assert tracker.screening.dropped == 30


def test_one_uncertain_point_of_the_second_detector_keeps_no_other_from_starting():
    tracker = Tracker()
    for k in range(30):
        stamp = round(k / RATE * NANOSECONDS)
        tracker.update(points(way(k)[:1], stamp, 0.25))
        other = points(np.array([[400.0, 300.0], [1e4, 1e4]]), stamp, 0.25)
        other.rows['cov_uu'][1] = other.rows['cov_vv'][1] = 1e6
        rows = tracker.update(other).rows
    assert np.abs(rows['u'] - 400).min() < 1


def test_no_more_detections_of_one_message_are_worked_on_than_allowed():
    rng, tracker = np.random.default_rng(0), Tracker(TrackerConfig(max_detections=4))
    tracker.screening.refuse = [].append
    others = points(way(0), size=(SIDE, SIDE))
    in_one_message(tracker, blobs(0, rng), others)
    assert tracker.screening.crowded_out == 2
