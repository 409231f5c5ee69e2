"""The tracker's work per frame, counted, so that neither load nor machine matters."""

import numpy as np
import pytest
from support.steps import count_work

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.tracking.tracker import Tracker

MOST = 1011
"""Most steps in an uneventful frame: 1008 with Python 3.11, a few more with 3.13. It keeps work
from being added unnoticed; it does not tell how long each takes."""


def far_apart(count: int, k: int) -> Detections:
    """Return objects with boxes, each on its own line, as seen in frame k."""
    rows, noise = np.zeros(count, DETECTION), np.random.default_rng(k).normal(0, 0.5, (2, count))
    rows['u'], rows['v'] = 60 + 2.0 * k + noise[0], 40.0 * (1 + np.arange(count)) + noise[1]
    rows['cov_uu'] = rows['cov_vv'] = 0.25
    rows['box_w'] = rows['box_h'] = 20
    rows['box_u'], rows['box_v'], rows['area'] = rows['u'] - 10, rows['v'] - 10, 300
    return Detections(rows, round(k * 1e9 / 30), image_size=(640, 640))


@pytest.mark.parametrize('count', [1, 10])
def test_a_frame_in_which_nothing_happens_takes_so_many_steps(count):
    tracker = Tracker()
    for k in range(60):
        tracker.update(far_apart(count, k))
    steps = [count_work(lambda k=k: tracker.update(far_apart(count, k))) for k in range(60, 75)]
    assert len(tracker.update(far_apart(count, 75)).rows) == count
    assert np.median(steps) <= MOST
