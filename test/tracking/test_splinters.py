"""Objects that are two detections for moments, without boxes to show that they are one."""

import numpy as np
import pytest
from support.silhouettes import points

from colortrack_ros.evaluation import Tally
from colortrack_ros.tracking import Tracker


def breaking(rng, rate, width, count=6, seconds=10.0):
    """Return objects on separate lanes that break in two every other second, for a third of it.

    :param width: of the objects; the pieces lie more than a quarter of it from the center [px].
    :return: position, (K, N, 2), and distance of the pieces, (K, N), 0 for a whole object [px].
    """
    t = np.arange(round(seconds * rate))[:, None] / rate
    speed = rng.uniform(60, 140, count) * rng.choice([-1, 1], count)
    lanes = (np.arange(count) + 0.5) * 100
    u = 400 + (t - seconds / 2) * speed
    position = np.stack([u, lanes + 0 * u], axis=-1)
    phase = (t + rng.uniform(0, 2, count)) % 2 - 1
    return position, np.where(np.abs(phase) < 1 / 6, width * (0.5 + 0.6 * np.abs(phase)), 0.0)


def play(position, apart, rng, rate, noise=0.5):
    """Return the score of the tracker over detections without boxes or covariances."""
    tracker, tally = Tracker(), Tally(20.0)
    for k, (truth, gap) in enumerate(zip(position, apart, strict=True)):
        aside = np.column_stack([gap, 0 * gap]) / 2
        z = np.concatenate([truth + aside, (truth - aside)[gap > 0]])
        z += rng.normal(0, noise, z.shape)
        rows = tracker.update(points(rng.permutation(z), round(k * 1e9 / rate), 0.0)).rows
        rows = rows[rows['state'] > 0]
        found = np.stack([rows['track_id'], rows['u'], rows['v']], axis=1)
        tally.add(np.column_stack([np.arange(len(truth)), truth]), found)
    return tally.score()


@pytest.mark.slow
@pytest.mark.parametrize(('rate', 'width'), [(30, 30.0), (15, 24.0), (60, 40.0)])
def test_pieces_do_not_live_on_in_what_is_whole_again(rate, width):
    """There are two tracks while an object is in pieces, and hardly longer."""
    idf1, rows = [], []
    for seed in range(2):
        rng = np.random.default_rng(seed)
        position, apart = breaking(rng, rate, width)
        score = play(position, apart, rng, rate)
        idf1.append(score.idf1)
        rows.append(score.false / np.count_nonzero(apart))
    assert np.mean(rows) < 2.5
    assert np.mean(idf1) > 0.8


@pytest.mark.slow
def test_two_that_were_seen_apart_for_long_are_no_pieces():
    """A pair that starts as one detection parts, and is a single detection again for a second."""
    t = np.arange(240)[:, None] / 30
    gap = np.interp(t[:, 0], [1.0, 1.01, 3.0, 3.01, 4.0, 4.01], [0, 30, 30, 0, 0, 30])[:, None]
    position = np.stack([100 + 50 * t, 300 + 0 * t], axis=-1)
    rng, tracker, seen = np.random.default_rng(0), Tracker(), []
    for k, (middle, apart) in enumerate(zip(position, gap, strict=True)):
        aside = np.array([[0, 0.5], [0, -0.5]]) * apart
        z = (middle + aside)[: 1 + (apart[0] > 0)]
        z = z + rng.normal(0, 0.5, z.shape)
        seen.append(tracker.update(points(z, round(k * 1e9 / 30), 0.0)).rows['track_id'].tolist())
    assert seen[80] == seen[100] == seen[-1]
    assert len(seen[100]) == 2
