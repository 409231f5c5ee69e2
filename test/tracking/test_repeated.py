"""A detector that finds objects twice costs no ID, least of all where they bounce."""

import numpy as np
import pytest
from support.silhouettes import points

from colortrack_ros.data import TENTATIVE
from colortrack_ros.tracking import Tracker

SIZE = np.array([640.0, 480.0])
BOX = 40.0
RATE = 30


def bouncing(rng, count, frames):
    """Return positions (frames, count, 2) [px] of objects that bounce between the borders.

    Their speed is 150 to 250 px/s.
    """
    speed, angle = rng.uniform(150, 250, count), rng.uniform(0, 2 * np.pi, count)
    velocity = speed[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    way = rng.uniform(0, SIZE, (count, 2)) + np.arange(frames)[:, None, None] / RATE * velocity
    return np.abs((way + SIZE) % (2 * SIZE) - SIZE)


def message(z, k):
    return points(z, round(k / RATE * 1e9), size=(BOX, BOX))


def names(paths, detections):
    """Return the sets of IDs that the paths, (K, N, 2), had within 20 px."""
    tracker, owned = Tracker(), [set() for _ in range(paths.shape[1])]
    for k, z in enumerate(detections):
        rows = tracker.update(message(z, k)).rows
        rows = rows[rows['state'] != TENTATIVE]
        apart = np.hypot(rows['u'] - paths[k][:, :1], rows['v'] - paths[k][:, 1:])
        between = np.hypot(*(paths[k][:, None] - paths[k]).T) + 1e3 * np.eye(len(paths[k]))
        for n in np.flatnonzero((apart.min(axis=1, initial=np.inf) < 20) & (between.min(0) > 60)):
            owned[n].add(int(rows['track_id'][apart[n].argmin()]))
    return owned


@pytest.mark.slow
@pytest.mark.parametrize('aside', [8.0, 14.0])
@pytest.mark.parametrize('seed', range(2))
def test_what_is_found_twice_keeps_its_id(seed, aside):
    """One in 17 is found again, off by a fifth or a third of its size; the order is random."""
    rng = np.random.default_rng(seed)
    paths, detections = bouncing(rng, 6, 300), []
    for centers in paths:
        z = centers + rng.normal(0, 1, centers.shape)
        angle = rng.uniform(0, 2 * np.pi, len(z))
        again = z + aside * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        both = np.concatenate([z, again[rng.random(len(z)) < 0.06]])
        detections.append(rng.permutation(both))
    assert max(map(len, names(paths, detections))) == 1


def test_what_comes_out_before_another_is_an_object_of_its_own():
    """Both are detected whole, as by networks; the second starts inside the first one's box."""
    k = np.arange(90)[:, None, None]
    first, second = np.array([[[100.0, 200.0]]]), np.array([[[100.0, 210.0]]])
    paths = np.concatenate([first + k * [2.0, 0.0], second + (k - 30) * [5.0, 0.0] + [62, 0]], 1)
    rng = np.random.default_rng(0)
    seen = paths + rng.normal(0, 0.5, paths.shape)
    detections = [z if frame >= 30 else z[:1] for frame, z in enumerate(seen)]
    tracker = Tracker()
    live = [tracker.update(message(z, frame)).rows for frame, z in enumerate(detections)]
    assert [set(rows['track_id'][rows['state'] != TENTATIVE]) for rows in live[40:]] == [
        {1, 2}
    ] * 50
