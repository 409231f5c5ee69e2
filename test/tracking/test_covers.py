"""What passes behind a cover keeps its size, and its ellipse allows for what is not known of it."""

import numpy as np
import pytest

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.ellipses import ELLIPSE_95
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig


def visible(center, side, cover, rng):
    """Return the row, or none, of what a square shows beside the cover."""
    low, high = center - side / 2, center + side / 2
    if center > np.mean(cover):
        low = max(low, cover[1])
    else:
        high = min(high, cover[0])
    if high - low < 2:
        return np.zeros(0, DETECTION)
    row = np.zeros(1, DETECTION)
    row['u'], row['v'] = np.array([(low + high) / 2, 200]) + rng.normal(0, 0.3, 2)
    row['cov_uu'] = row['cov_vv'] = 0.09
    row['box_u'], row['box_v'] = np.rint(low), np.rint(200 - side / 2)
    row['box_w'], row['box_h'] = np.rint(high) - row['box_u'] + 1, np.rint(side)
    row['area'], row['score'] = (high - low) * side, 1.0
    return row


def passing(side, step, cover, looked, seed):
    """Return errors along the way [px] and whether ellipses hold, for each frame that is cut.

    :param side, step, cover: of a square, its way in a frame, and where the cover is [px].
    :param looked: how much larger than it is the square looked, for 0.3 s until shortly before.
    """
    rng, tracker = np.random.default_rng(seed), Tracker(TrackerConfig(image_size=(1280, 400)))
    off, held = [], []
    for k, center in enumerate(np.arange(200.0, cover[1] + side, step)):
        before = (cover[0] - side / 2 - center) / step  # frames
        found = visible(center, side * (looked if 3 < before < 12 else 1.0), cover, rng)
        row = tracker.update(Detections(found, round(k * 1e9 / 30))).rows
        if before < 0 and len(found) and center - side / 2 < cover[1]:
            e = np.array([row['u'][0] - center, row['v'][0] - 200])
            off.append(e[0])
            held.append(e @ np.linalg.solve(row['covariance'][0, :2, :2], e) < ELLIPSE_95)
    return np.array(off), np.array(held)


def cut_on(way, side, cover):
    """Return whether ellipses hold in each frame of a square's way, (K,), that a cover cuts."""
    rng, tracker, held = (
        np.random.default_rng(0),
        Tracker(TrackerConfig(image_size=(1280, 400))),
        [],
    )
    for k, center in enumerate(way):
        found = visible(center, side, cover, rng)
        rows = tracker.update(Detections(found, round(k * 1e9 / 30))).rows
        if len(found) and len(rows) and found['box_w'][0] < side - 1:
            e = np.array([rows['u'][0] - center, rows['v'][0] - 200])
            held.append(e @ np.linalg.solve(rows['covariance'][0, :2, :2], e) < ELLIPSE_95)
    return np.array(held)


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(3))
def test_what_comes_out_from_behind_a_cover_is_as_large_as_it_was(seed):
    off, held = passing(80.0, 4.0, (400.0, 520.0), 1.0, seed)
    assert len(off) >= 20
    assert np.abs(off).max() < 2.5
    assert held.mean() > 0.95


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(4))
def test_ellipses_allow_for_a_size_that_is_wrong_for_as_long_as_something_is_cut(seed):
    _, held = passing(100.0, 3.0, (500.0, 640.0), 1.2, seed)
    assert held.mean() > 0.85


IN, OUT = np.arange(220.0, 266.0, 1.0), np.arange(284.0, 340.0, 1.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ('way', 'least'),
    [
        (np.arange(220.0, 340.0, 1.0), 0.88),  # goes past
        (np.concatenate([IN, IN[::-1]]), 0.88),  # turns back
        (np.concatenate([IN, np.full(60, IN[-1]), IN[::-1]]), 0.88),  # stands half covered
        (np.concatenate([np.full(3, 280.0), OUT]), 0.75),  # nobody knows its size
    ],
    ids=['past', 'back', 'stands', 'new'],
)
def test_ellipses_hold_what_is_cut_so_slowly_that_it_may_as_well_shrink_or_grow(way, least):
    held = cut_on(way, 40.0, (260.0, 300.0))
    assert len(held) > 30
    assert held.mean() > least


@pytest.mark.slow
@pytest.mark.parametrize('rate', [-0.01, 0.01])
def test_what_recedes_or_comes_nearer_with_one_side_still_is_not_taken_for_covered(rate):
    tracker, wide = Tracker(TrackerConfig(image_size=(1280, 720))), []
    for k, scale in enumerate(np.exp(rate * np.arange(120))):
        row, size = np.zeros(1, DETECTION), np.rint([80 * scale, 60 * scale])
        row['box_u'], row['box_v'] = 300, np.rint(300 - size[1] / 2)
        row['box_w'], row['box_h'] = size
        row['u'], row['v'] = 299.5 + 40 * scale, 300
        row['cov_uu'] = row['cov_vv'] = 0.09
        row['area'], row['score'] = size.prod(), 1.0
        rows = tracker.update(Detections(row, round(k * 1e9 / 30))).rows
        wide.append(rows['covariance'][0, 0, 0])
    assert max(wide[10:]) < 3.0


def test_of_what_a_part_was_detected_first_nothing_is_covered():
    """Its standard deviation was 18 px in place of 0.3, for as long as it stood."""
    tracker = Tracker(TrackerConfig(image_size=(1280, 720)))
    for k in range(30):
        row, width = np.zeros(1, DETECTION), 40 if k else 20
        row['box_u'], row['box_v'], row['box_w'], row['box_h'] = 300, 100, width, 40
        row['u'], row['v'] = 299.5 + width / 2, 119.5
        row['cov_uu'] = row['cov_vv'] = 0.09
        row['area'], row['score'] = 40 * width, 1.0
        rows = tracker.update(Detections(row, round(k * 1e9 / 30))).rows
    assert rows['covariance'][0, 0, 0] < 1.0
