"""A second is a second, however many frames it has."""

from functools import cache

import numpy as np
import pytest
from support.silhouettes import points

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig


@pytest.mark.parametrize('name', ['constant_velocity', 'known_acceleration', 'switched_pair'])
def test_steps_add_up_to_one_step_of_their_sum(name):
    rng = np.random.default_rng(0)
    steps = rng.uniform(0.001, 0.1, 40)
    banks = [Bank(MOTION_MODELS[name]((30.0, 900.0))) for _ in range(2)]
    for bank in banks:
        new = bank.at_rest(np.array([[3.0, 4.0]]), np.eye(2)[None], np.full(4, 50.0))
        bank.extend(new)
    for dt in steps:
        banks[0].predict(dt, 300.0**2)
    banks[1].predict(steps.sum(), 300.0**2)
    np.testing.assert_allclose(banks[0].mean, banks[1].mean, rtol=1e-9)
    np.testing.assert_allclose(banks[0].cov, banks[1].cov, rtol=1e-9, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize('empties', [1, 7, 200])
def test_a_second_unseen_is_as_uncertain_in_any_number_of_messages(empties):
    """Process noise is given, so that only time can make a difference."""

    def sigma(count):
        tracker = Tracker(TrackerConfig(process_noise=200.0, maneuvers=False))
        for k in range(31):
            seen = points([(100 + 5 * k, 300)], k * NANOSECONDS // 30, 1.0)
            rows = tracker.update(seen).rows
        for k in range(1, count + 1):
            rows = tracker.update(points([], NANOSECONDS + k * NANOSECONDS // count)).rows
        return np.sqrt(rows['covariance'][0].diagonal())

    np.testing.assert_allclose(sigma(empties), sigma(30), rtol=0.01)


@cache
def sigma_after(rate, seed):
    """Return the sigma of an object a second after three seconds at a rate of frames."""
    tracker, rng = Tracker(), np.random.default_rng(seed)
    for k in range(3 * rate + 1):
        z = np.array([[100 + 150 * k / rate, 300.0]]) + rng.normal(0, 1, (1, 2))
        tracker.update(points(z, k * NANOSECONDS // rate))
    return np.sqrt(tracker.update(points([], 4 * NANOSECONDS)).rows['covariance'][0, 0, 0])


@pytest.mark.slow
@pytest.mark.parametrize('rate', [15, 60, 200])
def test_a_second_unseen_is_as_uncertain_after_any_rate_of_frames(rate):
    """All is learned, maneuvers too; the mean of four objects that move straight for 3 s."""
    ratios = [sigma_after(rate, seed) / sigma_after(30, seed) for seed in range(4)]
    assert np.mean(ratios) == pytest.approx(1, rel=0.05)


def ids_of_a_flock(rate, seed):
    """Number of confirmed IDs of 16 animals, 40 px apart, that walk a few pixels a frame."""
    rng, tracker, ids = np.random.default_rng(seed), Tracker(), set()
    grid = np.stack(np.meshgrid(np.arange(4), np.arange(4)), axis=-1).reshape(-1, 2)
    place, velocity, stamp = 200 + 40.0 * grid, rng.normal(0, 2, (16, 2)), 0
    for _ in range(60):
        velocity += rng.normal(0, 0.5, velocity.shape) - 0.05 * velocity
        place += velocity - 0.02 * (place - 200 - 40 * grid)
        seen = place[rng.random(16) > 0.1]
        rows = tracker.update(points(seen + rng.normal(0, 1, seen.shape), stamp)).rows
        ids.update(rows['track_id'][rows['state'] == CONFIRMED].tolist())
        stamp += NANOSECONDS // rate
    return len(ids)


@pytest.mark.slow
def test_a_flock_of_which_a_picture_is_taken_each_second_keeps_its_ids():
    counts = [ids_of_a_flock(1, seed) for seed in range(3)]
    assert max(counts) <= 17, counts


def seen_again(rate, missed, config=None, frames=20):
    """IDs before and after a standing object is missed in so many frames on end."""
    tracker, ids = Tracker(config), []
    for k in range(frames):
        seen = [] if 0 <= k - 10 < missed else [(300.0, 300 + 0.1 * (k % 3))]
        rows = tracker.update(points(seen, round(k * NANOSECONDS / rate))).rows
        if k in (9, frames - 1):
            ids += rows['track_id'][rows['state'] == CONFIRMED].tolist()
    return ids


@pytest.mark.parametrize('rate', [0.6, 0.7, 1, 2, 3, 5])
@pytest.mark.parametrize('missed', [3, 4])
def test_what_a_slow_camera_misses_four_times_keeps_its_id(rate, missed):
    """With the memory of what was deleted switched off; stamps are rounded to nanoseconds."""
    assert seen_again(rate, missed, TrackerConfig(max_hidden=0.0)) == [1, 1]


@pytest.mark.parametrize('rate', [0.6, 0.7, 1])
@pytest.mark.parametrize('missed', [5, 6])
def test_what_a_slow_camera_misses_for_longer_is_remembered(rate, missed):
    """Four frames take about as long as max_hidden, or longer."""
    assert seen_again(rate, missed) == [1, 1]
    assert seen_again(rate, missed, TrackerConfig(max_hidden=0.0)) == [1, 2]


@pytest.mark.parametrize('period', [2.1, 2.5, 12.0])
def test_a_source_that_is_slower_than_max_dt_is_followed_from_the_third_frame_on(period):
    """A radar that turns once in 2.5 s: of each jump alone, the tracker restarts."""
    place = np.stack([np.full(6, 300.0), 100.0 + 80 * np.arange(6)], axis=1)
    tracker, told = Tracker(TrackerConfig(max_hidden=0.0)), []
    for k in range(12):
        seen = place[int(k == 8) :] + np.array([3.0 * k, 0.0])
        tracks = tracker.update(points(seen, round((1 + k) * period * NANOSECONDS)))
        told.append(bool(tracks.restarted))
    assert told == [k == 1 for k in range(12)]
    assert tracks.rows['track_id'].tolist() == [7, 8, 9, 10, 11, 12]  # 1 to 6 were before
    assert (tracks.rows['state'] == CONFIRMED).all()


def test_two_messages_of_each_turn_of_a_radar_are_of_one_frame():
    """As of two detectors: both have one stamp."""
    place = np.stack([np.full(6, 300.0), 100.0 + 80 * np.arange(6)], axis=1)
    tracker, told = Tracker(), []
    for k in range(16):
        detections = points(place[k % 2 :: 2], round((1 + k // 2) * 2.5 * NANOSECONDS))
        tracks = tracker.update(detections)
        told.append(bool(tracks.restarted))
    assert told == [k == 2 for k in range(16)]
    assert (tracks.rows['state'] == CONFIRMED).all()
    assert len(tracks.rows) == 6


@pytest.mark.parametrize('count', [1, 2, 4])
@pytest.mark.parametrize('period', [4.0, 8.0, 12.0])
def test_few_objects_are_followed_however_slow_their_source_is(count, period):
    """By a speed of 700 px/s they are 2800 px away in 4 s, and all detections of new objects."""
    place = np.stack([np.full(count, 300.0), 100.0 + 80 * np.arange(count)], axis=1)
    tracker, ids = Tracker(TrackerConfig(image_size=(1920, 1080))), set()
    for k in range(12):
        seen = place + np.array([20.0 * k, 0])
        rows = tracker.update(points(seen, round((1 + k) * period * NANOSECONDS))).rows
        ids.update(rows['track_id'][rows['state'] == CONFIRMED].tolist())
    assert len(ids) == count


def test_two_cuts_of_a_recording_restart_it_twice():
    tracker, stamp, told = Tracker(), 0.0, []
    for step in (0.1, 0.1, 5.0, 0.1, 0.1, 5.0, 0.1, 5.0, 14.0, 0.1):
        stamp += step
        tracks = tracker.update(points([(300.0, 300.0)], round(stamp * NANOSECONDS)))
        told.append(bool(tracks.restarted))
    assert told == [False, False, True, False, False, True, False, True, True, False]


def test_three_messages_of_a_slow_camera_that_are_lost_do_not_restart_it():
    """3.2 s are more than max_dt."""
    tracker = Tracker(TrackerConfig(max_hidden=0.0))
    for k in (0, 1, 2, 3, 4, 8, 9):
        tracks = tracker.update(points([(300.0, 300.0)], round(0.8 * k * NANOSECONDS)))
        assert not tracks.restarted
    assert tracks.rows['track_id'].tolist() == [1]


def test_what_a_slow_camera_misses_for_long_is_deleted():
    assert seen_again(1, 5, TrackerConfig(max_hidden=0.0)) == [1, 2]


def test_what_a_fast_camera_misses_is_deleted_after_the_time_that_was_set():
    config = TrackerConfig(max_hidden=0.0, max_time_since_update=0.1)
    assert seen_again(30, 2, config) == [1, 1]
    assert seen_again(30, 4, config) == [1, 2]


def test_a_camera_that_is_fast_again_is_waited_for_as_set():
    tracker, stamp = Tracker(TrackerConfig(max_hidden=0.0)), 0.0
    for k in range(60):
        stamp += 1.0 if k < 10 else 0.1
        seen = [] if 20 <= k < 40 else [(300.0, 300.0)]
        rows = tracker.update(points(seen, round(stamp * NANOSECONDS))).rows
    assert rows['track_id'].tolist() == [2]


def test_a_pause_is_no_lower_rate():
    """One missed message in a fast stream changes nothing of what is assumed of speeds."""
    tracker = Tracker()
    for k, frame in enumerate((0, 1, 2, 3, 33, 34, 35, 65, 66)):
        rows = tracker.update(points([(100 + k, 300)], frame * NANOSECONDS // 30)).rows
        assert tracker._adaptation.slowness == 1.0
    assert rows['track_id'].tolist() == [1]
