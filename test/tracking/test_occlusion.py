"""Objects behind a bar, behind each other, and at the edge of the picture."""

from dataclasses import replace

import numpy as np
import pytest
from support.silhouettes import discs
from support.silhouettes import FRAME
from support.silhouettes import inside
from support.silhouettes import run

from colortrack_ros.data import CONFIRMED
from colortrack_ros.evaluation import score
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

SHAPE, RADIUS, SPEED = (240, 480), 15, 80.0


def scene(paths, frames, bar=None):
    """Return truth and detections of discs that move on paths, functions of time [s]."""
    truth, detections = [], []
    for k in range(frames):
        centers = np.array([path(k / 24) for path in paths])
        here = inside(centers, RADIUS, SHAPE)
        truth.append(np.column_stack([np.flatnonzero(here), centers[here]]))
        detections.append(discs(centers, RADIUS, SHAPE, bar, k * FRAME))
    return truth, detections


def procession(number):
    return [
        lambda t, i=i: (SPEED * t - 20 - 60 * i, 40 + 35 * i + 3 * np.sin(2 * t + i))
        for i in range(number)
    ]


@pytest.mark.slow
@pytest.mark.parametrize('bar', [None, (230, 280), (230, 310), (230, 250)])
def test_each_object_keeps_its_track_through_the_picture_and_behind_a_bar(bar):
    truth, detections = scene(procession(4), 220, bar)
    result = score(truth, run(Tracker(), detections), 20.0)
    assert result.tracks_of == {i: [i + 1] for i in range(4)}
    assert result.false_tracks == []
    assert result.rmse < 3.0  # a tenth of the diameter, hidden stretches included


@pytest.mark.slow
@pytest.mark.parametrize('direction', [1, -1])
@pytest.mark.parametrize('seeming', [1.15, 0.88], ids=['leaves behind it', 'shade'])
def test_one_that_has_looked_larger_or_smaller_goes_on_behind_a_cover(seeming, direction):
    """Something of its color behind it, or a shade: not its width, its way tells where it is."""
    shape, radius, bar, tracker, held, ids = (240, 960), 30, (420, 560), Tracker(), [], set()
    for k in range(80):
        u = 480 + direction * 12 * (k - 40)
        looks = radius * (seeming if seeming < 1 or k < 30 else 1)
        looks = looks if k >= 16 else radius
        rows = tracker.update(discs(np.array([[u, 120.0]]), looks, shape, bar, k * FRAME)).rows
        ids |= set(rows['track_id'][rows['state'] > 0].tolist())
        if abs(u - 480) < 100:
            e = np.array([rows['u'][0] - u, rows['v'][0] - 120])
            held.append(e @ np.linalg.solve(rows['covariance'][0][:2, :2], e) < 5.99)
    assert ids == {1}
    assert np.mean(held) >= 0.9, '95 % ellipses'


@pytest.mark.slow
def test_without_boxes_the_cut_blobs_mislead():
    truth, detections = scene(procession(4), 220, (230, 310))
    blind = Tracker(replace(TrackerConfig(), use_boxes=False))
    assert score(truth, run(blind, detections), 20.0).misses > 20


@pytest.mark.slow
def test_two_objects_that_cross_come_out_on_their_own_sides():
    paths = [lambda t: (SPEED * t - 20, 40 + 30 * t), lambda t: (500 - SPEED * t, 50 + 30 * t)]
    truth, detections = scene(paths, 170)
    result = score(truth, run(Tracker(), detections), 20.0)
    assert (result.switches, result.misses, result.false_tracks) == (0, 0, [])
    assert result.rmse < 3.0  # a tenth of the diameter, hidden stretches included


@pytest.mark.slow
def test_objects_that_merge_share_the_blob():
    """Two discs are a single blob for two seconds; each is measured at its own side, in its box."""
    paths = [
        lambda t, i=i: (40 + SPEED * t, 100 + (2 * i - 1) * (13 + 4 * abs(t - 2))) for i in range(2)
    ]
    truth, detections = scene(paths, 96)
    assert sum(len(one.rows) == 1 for one in detections) > 10
    tracker, followed = Tracker(), 0
    for objects, one in zip(truth, detections, strict=True):
        rows = tracker.update(one).rows
        if rows['state'].any():
            assert rows['state'].tolist() == [CONFIRMED] * 2
            np.testing.assert_allclose(rows['v'], objects[:, 2], atol=2.0)
            boxes = np.stack([rows['box_w'], rows['box_h']])
            assert np.abs(boxes - 2 * RADIUS).max() <= 2, 'each its own'
            assert rows['area'] == pytest.approx(np.pi * RADIUS**2, rel=0.05)
            followed += 1
    assert followed > 90
