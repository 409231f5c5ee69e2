"""The next detection tells a stray from a turn."""

import numpy as np
import pytest
from support.silhouettes import message
from support.silhouettes import RATE

from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

FALL = 3000.0
"""Acceleration of a falling object [px/s^2]."""


def played(path, strays, rng):
    """Yield the confirmed tracks of one object after each frame; some detections stray."""
    tracker = Tracker()
    for k, x in enumerate(path):
        off = strays.get(k, (0.0, 0.0))
        rows = tracker.update(message([x + rng.normal(0, 1, 2) + off], k)).rows
        yield rows[rows['state'] > 0]


def is_right(rows, velocity=(240.0, 90.0)):
    return np.hypot(rows['du'][0] - velocity[0], rows['dv'][0] - velocity[1]) < 60


def straight(count=90):
    return np.array([100.0, 100.0]) + np.arange(count)[:, None] * [8.0, 3.0]


@pytest.mark.parametrize('off', [(0.0, 21.0), (-20.0, 6.0), (14.0, -14.0)])
def test_a_track_goes_on_after_a_stray_that_looked_like_a_turn(off):
    path = straight()
    frames = list(played(path, {60: off}, np.random.default_rng(0)))
    assert {int(i) for rows in frames[20:] for i in rows['track_id']} == {1}
    for rows, x in zip(frames[61:], path[61:], strict=True):
        assert np.hypot(rows['u'][0] - x[0], rows['v'][0] - x[1]) < 6
        assert is_right(rows)


def test_a_stray_before_a_gap_is_told_after_it():
    path = straight()
    tracker, rng = Tracker(), np.random.default_rng(0)
    for k, x in enumerate(path):
        z = [] if k in (61, 62) else [x + rng.normal(0, 1, 2) + (0.0, 21.0 * (k == 60))]
        rows = tracker.update(message(z, k)).rows
        assert k <= 62 or is_right(rows)
    assert rows['track_id'].tolist() == [1]


def test_what_falls_is_doubted_falling():
    """After a gap of two frames, in which a fall adds 300 px/s, it has the velocity of the fall."""
    t, errors = np.arange(44)[:, None] / RATE, []
    path = (100.0, 4000.0) + t * (240.0, -4000.0) + t**2 / 2 * (0.0, FALL)
    for seed in range(5):
        config = TrackerConfig(motion_model='known_acceleration', acceleration_span=0.1)
        tracker, rng = Tracker(config), np.random.default_rng(seed)
        for k, x in enumerate(path):
            z = [] if k in (41, 42) else [x + rng.normal(0, 1, 2) + (30.0 * (k == 40), 0.0)]
            rows = tracker.update(message(np.reshape(z, (-1, 2)), k)).rows
        assert rows['track_id'].tolist() == [1]
        errors.append(rows['dv'][0] - (FALL * k / RATE - 4000.0))
    assert abs(np.mean(errors)) < 30


def test_a_turn_is_followed_at_once():
    path = straight()
    path[60:] = path[60] + np.arange(30)[:, None] * [-2.0, 9.0]
    frames = list(played(path, {}, np.random.default_rng(0)))
    assert {int(i) for rows in frames[20:] for i in rows['track_id']} == {1}
    for rows, x in zip(frames[63:], path[63:], strict=True):
        assert np.hypot(rows['u'][0] - x[0], rows['v'][0] - x[1]) < 6
        assert is_right(rows, (-60.0, 270.0))


@pytest.mark.slow
def test_strays_in_a_crowd_break_no_track():
    rng = np.random.default_rng(5)
    start = np.stack([rng.uniform(100, 300, 8), 60 + 85.0 * np.arange(8)], axis=1)
    speed = np.stack([rng.uniform(1, 6, 8), rng.uniform(-0.2, 0.2, 8)], axis=1)
    tracker, names = Tracker(), set()
    for k in range(150):
        z = start + k * speed
        off = np.where(rng.random((8, 1)) < 0.05 * (k > 15), rng.normal(0, 20, (8, 2)), 0.0)
        rows = tracker.update(message(z + rng.normal(0, 1, z.shape) + off, k)).rows
        near = np.hypot(rows['u'][:, None] - z[:, 0], rows['v'][:, None] - z[:, 1]) < 10
        names |= {(int(n), int(rows['track_id'][i])) for i, n in zip(*near.nonzero(), strict=True)
                  if rows['state'][i] > 0 and k > 15}  # fmt: skip
    assert len({track for _, track in names}) == 8
