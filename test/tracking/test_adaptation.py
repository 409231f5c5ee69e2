"""What the tracker learns of the scene does as well as known values."""

import math

import numpy as np
import pytest
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.evaluation import Tally
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.sizes import Sizes

DT = 1 / 24


def wandering(acceleration, turns, frames=200, count=12, speed=150.0, seed=0):
    """Return the true positions (frames, count, 2) of objects far from each other."""
    rng = np.random.default_rng(seed)
    x = np.arange(count)[:, None] * [3000.0, 0.0]
    v = rng.normal(0, speed, (count, 2))
    for _ in range(frames):
        turn = rng.random(count) < turns * DT
        v[turn] = rng.normal(0, speed, (turn.sum(), 2))
        a = rng.normal(0, acceleration, (count, 2))
        x, v = x + v * DT + a * DT**2 / 2, v + a * DT
        yield x


def errors(config, paths, seed=1):
    """Return the RMS position error after the first 50 frames, and the tracker."""
    rng = np.random.default_rng(seed)
    tracker, squares = Tracker(config), []
    for k, x in enumerate(paths):
        rows = tracker.update(points(x + rng.normal(0, 1, x.shape), k * FRAME, 1.0)).rows
        if k > 50:
            at = np.stack([rows['u'], rows['v']], axis=1)
            squares.append(((at[:, None] - x) ** 2).sum(-1).min(axis=0))
    return np.sqrt(np.mean(squares)), tracker


@pytest.mark.slow
@pytest.mark.parametrize('acceleration', [20.0, 300.0, 3000.0])
def test_learned_process_noise_is_as_good_as_the_true_one(acceleration):
    known = TrackerConfig(process_noise=acceleration, maneuvers=False)
    best, _ = errors(known, wandering(acceleration, 0.0))
    learned, tracker = errors(TrackerConfig(), wandering(acceleration, 0.0))
    assert learned < 1.2 * best
    assert len(tracker.update(points([], 200 * FRAME)).rows) == 12


@pytest.mark.slow
def test_turns_cost_no_track_and_little_precision():
    learned, tracker = errors(TrackerConfig(), wandering(20.0, 0.7))
    assert tracker.update(points([], 200 * FRAME)).rows['track_id'].tolist() == list(range(1, 13))
    assert learned < 1.3


@pytest.mark.slow
def test_without_maneuvers_turns_cost_tracks():
    config = TrackerConfig(maneuvers=False, process_noise=20.0)
    _, tracker = errors(config, wandering(20.0, 0.7))
    assert max(tracker.update(points([], 200 * FRAME)).rows['track_id']) > 12


@pytest.mark.parametrize('speed', [120.0, 300.0])
def test_the_first_two_frames_of_a_crowd_tell_its_speed(speed):
    rng = np.random.default_rng(0)
    before = rng.uniform(0, 3000, (1000, 2))
    after = before + rng.normal(0, speed / 30, before.shape)
    learned = Adaptation(1.5)
    learned.meet(before, after, 1 / 30)
    assert (0.8 * speed < learned.speed).all()
    assert (learned.speed < 1.2 * speed).all()


def test_the_first_two_frames_of_a_few_objects_tell_nothing():
    learned = Adaptation(1.5)
    before = learned.speed
    learned.meet(np.zeros((4, 2)), np.zeros((4, 2)), 1 / 30)
    assert (learned.speed == before).all()


@pytest.mark.parametrize('rate', [1, 5, 30])
@pytest.mark.parametrize(('count', 'way'), [(8, 1.5), (16, 4.0), (60, 4.0)])
def test_slow_ones_of_which_some_are_missed_are_known_to_be_slow_from_the_second_frame(
    count, way, rate
):
    """Though who is missed has a neighbor's detection as the nearest one."""
    rng = np.random.default_rng(0)
    before = rng.uniform(0, 40 * math.sqrt(count), (count, 2))
    after = before + rng.normal(0, way, before.shape)
    after = np.concatenate([after[count // 5 :], rng.uniform(0, 40 * math.sqrt(count), (3, 2))])
    learned = Adaptation(1.5)
    first = learned.speed[0]
    learned.meet(before, rng.permutation(after), 1 / rate)
    assert (learned.speed < max(3 * way * rate, 0.4 * first, 101)).all()


def test_ways_as_far_as_the_next_neighbor_leave_the_speed_as_assumed():
    rng = np.random.default_rng(0)
    before, after = rng.uniform(0, 300, (2, 40, 2))
    learned = Adaptation(1.5)
    first = learned.speed[0]
    learned.meet(before, after, 0.1)
    assert (learned.speed > 0.6 * first).all()


def follow(tracker, tally, place, rng, stamp):
    """Track what is detected of true places, (N, 2), one time in ten nothing, and judge it."""
    seen = (place + rng.normal(0, 1.0, place.shape))[rng.random(len(place)) >= 0.1]
    rows = tracker.update(points(rng.permutation(seen), stamp)).rows
    rows = rows[rows['state'] != TENTATIVE]
    found = np.stack([rows['track_id'], rows['u'], rows['v']], axis=1)
    tally.add(np.column_stack([np.arange(len(place)), place]), found)


def test_a_herd_filmed_once_a_second_keeps_its_ids_from_the_start():
    """Sixteen that walk by 2 px, 30 px apart, and are missed one time in ten."""
    switches = 0
    for seed in range(5):
        rng = np.random.default_rng(seed)
        place = 30.0 * np.stack(np.meshgrid(range(4), range(4)), axis=-1).reshape(-1, 2)
        place += 400 + rng.uniform(-5, 5, place.shape)
        tracker, tally = Tracker(TrackerConfig(image_size=(1200, 900))), Tally(15.0)
        for k in range(12):
            place += rng.normal(0, 2.0, place.shape)
            follow(tracker, tally, place, rng, k * NANOSECONDS)
        switches += tally.score().switches
    assert switches < 30


@pytest.mark.parametrize('period', [0.5, 1.0, 1.9])
@pytest.mark.parametrize('count', [1, 2, 4])
def test_a_few_that_are_filmed_seldom_keep_their_ids(count, period):
    """They move by some 4 px from one picture to the next, and are missed one time in ten."""
    made = 0
    for seed in range(4):
        rng = np.random.default_rng(seed)
        place, tracker = rng.uniform(100, 500, (count, 2)), Tracker(TrackerConfig())
        step = rng.normal(0, 3.0, place.shape)
        for k in range(42):
            place += step
            seen = rng.random(count) >= (0.1 if k > 2 else 0.0)
            stamp = round(k * period * NANOSECONDS)
            rows = tracker.update(
                points((place + rng.normal(0, 0.5, place.shape))[seen], stamp)
            ).rows
            if k == 2:
                made -= int(max(rows['track_id']))
        assert len(rows) == count
        made += int(max(rows['track_id']))
    assert made == 0


def test_a_pause_after_the_first_picture_does_not_make_fast_ones_slow():
    """Two at 700 px/s: each gets a new ID after the pause at most, and keeps it."""
    made = 0
    for seed in range(4):
        rng = np.random.default_rng(seed)
        place, angle = rng.uniform(900, 1000, (2, 2)), rng.uniform(0, 7, 2)
        way = 700 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        tracker = Tracker(TrackerConfig(image_size=(4000, 4000)))
        for t in (0.0, *(1.5 + np.arange(40) / 30)):
            seen = (place + way * t + rng.normal(0, 0.5, way.shape))[rng.random(2) < 0.9]
            rows = tracker.update(points(seen, round(t * NANOSECONDS))).rows
        made += int(max(rows['track_id']))
    assert made <= 4 * 4


@pytest.mark.filterwarnings('error')
def test_one_picture_in_a_quarter_of_an_hour_is_waited_for():
    """Four of these periods are longer than any parameter may be."""
    tracker = Tracker(TrackerConfig(max_dt=3600.0))
    for k in range(5):
        tracks = tracker.update(points([(300.0, 200.0)], k * 1000 * NANOSECONDS))
        assert tracks.restarted == ''
    assert np.isfinite(tracks.rows['u']).all()


def test_what_rests_at_first_and_bursts_into_motion_keeps_its_ids():
    """Eight balls at rest for a second, hit all at once; each is missed one time in ten."""
    switches = 0
    for seed in range(4):
        rng = np.random.default_rng(seed)
        place, angle = rng.uniform(100, (1180, 620), (8, 2)), rng.uniform(0, 7, 8)
        velocity = 400 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        tracker, tally = Tracker(TrackerConfig(image_size=(1280, 720))), Tally(20.0)
        for k in range(60):
            now = place + velocity * max(0, k - 30) / 30
            follow(tracker, tally, now, rng, k * FRAME)
        switches += tally.score().switches
    assert switches < 4


def test_new_objects_are_expected_at_the_border_of_what_has_been_seen():
    learned = Adaptation(1.5)
    learned.learn_size(np.array([[0.0, 0.0], [320.0, 180.0]]))
    learned.learn_new(0, np.array([[2.0, 90.0], [160.0, 3.0], [318.0, 20.0]]))
    border, inside = learned.birth_places(np.array([[3.0, 90.0], [160.0, 90.0]]))
    assert border > 10 * inside


@pytest.mark.parametrize(('known', 'ratio'), [(True, 1.0), (False, 1.5)])
def test_a_few_new_objects_show_how_small_the_picture_is(known, ratio):
    """Without a size, three objects in 320x240 do not make it 640x480."""
    learned, size = Adaptation(1.5), np.array([320.0, 240.0])
    if known:
        learned.know_size((320, 240))
    learned.learn_size(np.array([[0.0, 0.0], size]))
    learned.learn_new(0, np.array([[60.0, 60.0], [260.0, 200.0], [100.0, 200.0]]))
    nearer = (np.arange(10**5) + 0.5) / 10**5  # share of the picture nearer to the border
    z = size / 2 + np.array([0.0, 0.5]) * size * np.sqrt(1 - nearer)[:, None]
    total = learned.birth_places(z).mean() * size.prod()
    assert 1 / ratio <= total * (1 + 1e-9) <= 1 + 1e-6


def test_where_all_are_alike_size_soon_says_nothing():
    """Of balls of one size, the tenth that is like the others is no coincidence."""
    sizes, ball = Sizes(), np.array([[20.0, 20.0]])
    first = sizes.log_fit(ball, ball)[0]
    for _ in range(10):
        sizes.learn_alike(ball, ball)
    assert first > 1.5
    assert sizes.log_fit(ball, ball)[0] < 0.5
