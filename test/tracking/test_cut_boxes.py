"""Boxes of a network that end at the picture's border keep the centers of complete objects."""

import numpy as np
import pytest

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import TENTATIVE
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

PICTURE = np.array([640.0, 480.0])
SIZE = np.array([50.0, 80.0])
RATE = 30


def crossing(frames):
    """Return centers (frames, 4, 2) [px]: two objects pass, two leave by half and return."""
    t = np.arange(frames)[:, None] / RATE
    passing = np.stack([320 + [[-40.0, 40.0]] * (t - 1), 240 + 0 * t + [[-15.0, 15.0]]], axis=2)
    out = np.abs(np.array([[180.0, 300.0]]) - 90 * t)
    leaving = np.stack([out, 80 + 0 * t + [[0.0, 320.0]]], axis=2)
    return np.concatenate([passing, leaving], axis=1)


def message(centers, k, *, clip):
    """Return boxes around centers, clipped at the border or reaching over it; no covariances."""
    low, high = centers - SIZE / 2, centers + SIZE / 2
    if clip:
        low, high = np.maximum(low, 0), np.minimum(high, PICTURE)
    rows = np.zeros(len(centers), DETECTION)
    rows['u'], rows['v'] = ((low + high) / 2).T
    rows['box_u'], rows['box_v'] = low.T
    rows['box_w'], rows['box_h'] = (high - low).T
    rows['area'], rows['score'] = rows['box_w'] * rows['box_h'], 1.0
    return Detections(rows, round(k / RATE * 1e9))


@pytest.mark.slow
@pytest.mark.parametrize('clip', [True, False], ids=['clipped', 'beyond'])
@pytest.mark.parametrize('seed', range(3))
def test_centers_and_ellipses_hold_where_the_border_cuts(seed, clip):
    rng, paths = np.random.default_rng(seed), crossing(180)
    tracker = Tracker(TrackerConfig(image_size=(640, 480)))
    off, held = [], []
    for k, truth in enumerate(paths):
        z = truth + rng.normal(0, 1, truth.shape)
        rows = tracker.update(message(z, k, clip=clip)).rows
        rows = rows[rows['state'] != TENTATIVE]
        for center in truth[2:][truth[2:, 0] < SIZE[0] / 2]:
            e = np.stack([rows['u'], rows['v']], axis=1) - center
            nearest = np.hypot(*e.T).argmin()
            e, P = e[nearest], rows['covariance'][nearest, :2, :2]
            off.append(e)
            held.append(e @ np.linalg.solve(P, e) < 5.99)
    assert set(tracker.update(message(paths[-1], 180, clip=clip)).rows['track_id']) == {1, 2, 3, 4}
    assert np.sqrt(np.mean(np.square(off))) < 2.0
    assert np.mean(held) > 0.8
