"""Who is who of two that a post cuts by degrees, hides, and that turn behind it."""

from itertools import chain

import numpy as np
import pytest

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

RATE, FRAMES, POST = 30, 80, (280.0, 360.0)
T = (np.arange(FRAMES) - FRAMES / 2) / RATE


def pieces(center, size, rng):
    """Return the rows of what is visible beside the post of a square."""
    center = center + rng.normal(0, 0.5, 2)
    low, high = center - size / 2, center + size / 2
    left, right = (low[0], min(high[0], POST[0])), (max(low[0], POST[1]), high[0])
    rows = []
    for a, b in (left, right):
        if b - a < max(0.2 * size, 2.5):
            continue
        row = np.zeros(1, DETECTION)
        row['u'], row['v'], row['cov_uu'], row['cov_vv'] = (a + b) / 2, center[1], 0.25, 0.25
        row['box_u'], row['box_v'] = np.rint([a, low[1]])
        row['box_w'], row['box_h'] = np.rint(b) - np.rint(a), np.rint(high[1]) - np.rint(low[1])
        row['area'], row['score'] = (b - a) * size, 1.0
        rows.append(row)
    return rows


def play(u, sizes, seed=0, colors=(1, 1), *, growth=0.0, pauses=False):
    """Return the IDs of N on a line, u (FRAMES, N) [px], at the start and at the end.

    :param growth: of all sizes [1/s].
    :param pauses: whether an empty message follows each.
    """
    rng, names = np.random.default_rng(seed), []
    tracker = Tracker(TrackerConfig(image_size=(640, 480)))
    for k, both in enumerate(u):
        now = np.array(sizes) * np.exp(growth * T[k])
        parts = [pieces(np.array([x, 240.0]), s, rng) for x, s in zip(both, now, strict=True)]
        for some, color in zip(parts, colors, strict=True):
            for row in some:
                row['color'] = color
        rows = np.concatenate([np.zeros(0, DETECTION), *chain(*parts)])
        tracks = tracker.update(Detections(rows, round(k * 1e9 / RATE))).rows
        if pauses:
            tracker.update(Detections(rows[:0], round((k + 0.5) * 1e9 / RATE)))
        if k in (RATE // 2, FRAMES - 1):
            nearest = np.abs(both[:, None] - tracks['u']).argmin(axis=1)
            names.append(tracks['track_id'][nearest].tolist())
    return names


@pytest.mark.slow
@pytest.mark.parametrize('sizes', [(16.0, 24.0), (24.0, 16.0), (12.0, 36.0), (30.0, 15.0)])
def test_two_that_turn_behind_a_post_come_out_as_themselves(sizes):
    contact = 320 + (sizes[0] - sizes[1]) / 2
    for seed, speed in enumerate((110.0, 150.0, 190.0)):
        way = np.abs(T) * speed
        u = np.stack([contact - sizes[0] / 2 - way, contact + sizes[1] / 2 + way], axis=1)
        start, end = play(u, sizes, seed)
        assert start == end, speed


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(3))
def test_two_of_one_size_that_pass_each_other_behind_a_post_are_not_exchanged(seed):
    u = np.stack([320 - 150 * T, 320 + 130 * T], axis=1)
    start, end = play(u, (20.0, 20.0), seed)
    assert start == end


def test_a_detector_that_looks_at_every_second_picture_tells_them_apart():
    way = np.abs(T) * 190
    u = np.stack([312 - way, 332 + way], axis=1)
    start, end = play(u, (24.0, 16.0), pauses=True)
    assert start == end


def test_two_that_pass_each_other_behind_a_post_and_come_nearer_are_not_exchanged():
    u = np.stack([320 + 110 * T, 320 - 99 * T], axis=1)
    start, end = play(u, (20.0, 30.0), growth=0.4)
    assert start == end


def test_one_of_another_color_between_two_that_turn_is_none_of_them():
    way = np.abs(T) * 150
    u = np.stack([308 - way, 328 + way, 330 + way], axis=1)
    start, end = play(u, (16.0, 24.0, 20.0), colors=(1, 1, 2))
    assert start == end
