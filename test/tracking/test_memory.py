"""Objects that return long after their tracks were deleted."""

import numpy as np
import pytest
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.motion.constant_velocity import ConstantVelocity
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.memory import Memory
from colortrack_ros.tracking.memory import MOST_REMEMBERED
from colortrack_ros.tracking.population import Population
from colortrack_ros.tracking.records import FIELDS

SEEN = 40
"""Frames in which objects are seen, before and after the gap."""


def ids(way, seconds, other=None, color=0, **options):
    """Return the IDs in the last frames before and after some seconds without a detection.

    :param way: returns (u, v) at a time in frames.
    :param other, color: way and color of the object seen afterwards; the same way if None.
    """
    tracker, hidden = Tracker(TrackerConfig(image_size=(640, 480), **options)), round(24 * seconds)
    for k in range(SEEN):
        rows = tracker.update(points([way(k)], k * FRAME, 0.5)).rows
    before = rows['track_id'].tolist()
    for k in range(SEEN, SEEN + hidden):
        tracker.update(points([], k * FRAME))
    for k in range(SEEN + hidden, SEEN + hidden + SEEN):
        rows = tracker.update(points([(other or way)(k)], k * FRAME, 0.5, color)).rows
    return before, rows['track_id'].tolist()


def straight(k):
    return 50 + 2.0 * k, 200.0


@pytest.mark.parametrize('seconds', [1.4, 2.0, 3.0, 5.0])
def test_what_goes_straight_on_unseen_comes_back_with_its_id(seconds):
    before, after = ids(straight, seconds)
    assert before == after == [1]


def test_what_stood_still_comes_back_in_its_place():
    before, after = ids(lambda _: (300, 200), 4.0)
    assert before == after == [1]


def test_a_track_that_is_only_remembered_is_not_published():
    tracker = Tracker(TrackerConfig(min_score=0.0))
    for k in range(SEEN):
        tracker.update(points([(300, 200)], k * FRAME))
    rows = [len(tracker.update(points([], k * FRAME)).rows) for k in range(SEEN, SEEN + 80)]
    assert rows[:30] == [1] * 30
    assert rows[40:] == [0] * 40


def test_longer_than_max_hidden_is_for_ever():
    before, after = ids(straight, 4.0, max_hidden=3.0)
    assert (before, len(after)) == ([1], 1)
    assert after != [1]


def test_nothing_is_remembered_that_is_not_to_be():
    before, after = ids(straight, 2.0, max_hidden=0.0)
    assert (before, len(after)) == ([1], 1)
    assert after != [1]


def test_another_color_is_another_object():
    _, after = ids(straight, 2.0, color=1)
    assert after != [1]


def test_what_has_left_the_picture_does_not_come_back_as_what_enters_elsewhere():
    _, after = ids(lambda k: (560 + 3.0 * k, 200), 2.0, other=lambda k: (2.0 * (k - 90), 300))
    assert len(after) == 1
    assert after != [1]


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(4))
def test_what_turns_back_at_the_border_keeps_its_id_though_it_is_missed_there(seed):
    """Four points go back and forth for 8 s between the borders of the picture."""
    rng, size = np.random.default_rng(seed), np.array([320, 240])
    start, velocity = rng.uniform(0, size, (4, 2)), rng.uniform(40, 100, (4, 2))
    tracker, names = Tracker(TrackerConfig(image_size=(320, 240))), set()
    for k in range(8 * 60):
        z = size - np.abs((start + velocity * k / 60) % (2 * size) - size)
        z = (z + rng.normal(0, 1, z.shape))[rng.random(4) < 0.7]
        rows = tracker.update(points(z, round(k / 60 * 1e9))).rows
        names |= set(rows['track_id'][rows['state'] != TENTATIVE])
    assert len(names) == 4


def test_what_enters_where_another_has_just_left_is_a_new_object():
    _, after = ids(lambda k: (560 + 3.0 * k, 200), 0.6, other=lambda k: (639 - 2 * (k - 55), 290))
    assert len(after) == 1
    assert after != [1]


def test_two_that_were_hidden_together_come_back_as_themselves():
    tracker = Tracker()
    for k in range(SEEN + 70 + SEEN):
        z = [straight(k), (600 - 2.0 * k, 240)]
        hidden = SEEN <= k < SEEN + 70
        rows = tracker.update(points([] if hidden else z, k * FRAME, 0.5)).rows
    by_id = rows[np.argsort(rows['track_id'])]
    assert by_id['track_id'].tolist() == [1, 2]
    assert by_id['v'] == pytest.approx([200, 240], abs=3)
    assert rows['track_id'].tolist() == [1, 2]


@pytest.mark.parametrize('swapped', [False, True])
def test_two_that_change_places_unseen_are_told_apart_by_their_sizes(swapped):
    tracker, size = Tracker(), np.array([20.0, 60.0])
    for k in range(SEEN + 24 * 3 + SEEN):
        late = k >= SEEN + 24 * 3
        width = (size[::-1] if late and swapped else size)[:, None]
        detections = points([(200, 200), (500, 200)], k * FRAME, 0.5, size=width)
        if k >= SEEN and not late:
            detections = points([], k * FRAME)
        rows = tracker.update(detections).rows
        if k == SEEN - 1:
            before = dict(zip(rows['box_w'], rows['track_id'], strict=True))
    assert dict(zip(rows['box_w'], rows['track_id'], strict=True)) == before


@pytest.mark.slow
@pytest.mark.parametrize('rate', [15, 30, 60])
def test_what_begins_in_the_open_is_not_what_was_taken_away_there(rate):
    """One is put down every half a second, and taken away 1 to 4 s later: one of 24 may err."""
    rng, count = np.random.default_rng(rate), 24
    start, way = rng.uniform((80, 80), (560, 400), (count, 2)), rng.uniform(-40, 40, (count, 2))
    begin = np.arange(count) / 2
    end = begin + rng.uniform(1.0, 4.0, count)
    tracker, names = Tracker(), set()
    for k in range(12 * rate):
        here = np.flatnonzero((begin <= k / rate) & (k / rate < end))
        z = (start + way * (k / rate - begin)[:, None])[here]
        rows = tracker.update(points(z + rng.normal(0, 0.5, z.shape), round(k / rate * 1e9))).rows
        names |= set(rows['track_id'][rows['state'] != TENTATIVE])
    assert len(names) >= count - 1


def test_a_reset_forgets():
    tracker = Tracker()
    for k in range(SEEN):
        tracker.update(points([straight(k)], k * FRAME))
    for k in range(SEEN, SEEN + 50):
        tracker.update(points([], k * FRAME))
    tracker.reset()
    for k in range(SEEN + 50, SEEN + 60):
        rows = tracker.update(points([straight(k)], k * FRAME)).rows
    assert len(rows) == 1
    assert rows['track_id'] > 1


def test_a_crowd_is_not_remembered_without_end():
    memory = Memory(TrackTable(Bank(ConstantVelocity()), FIELDS), Population([]))
    gone = TrackTable(Bank(ConstantVelocity()), FIELDS)
    z = np.zeros((50, 2))
    gone.initiate(gone.filters.at_rest(z, np.tile(np.eye(2), (50, 1, 1)), np.ones(4)), 0)
    for k in range(10):
        memory.remember(gone, k * FRAME, Adaptation(1.5), TrackerConfig())
    memory.advance(10 * FRAME, Adaptation(1.5), TrackerConfig())
    assert len(memory.tracks) == MOST_REMEMBERED
