"""Detections of which some have no box, as the contract allows: what is not known is 0."""

import numpy as np
import pytest

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.tracking import Tracker

SIDES = np.array([18.0, 30.0, 24.0])
"""Of the boxes of the objects [px]."""


def error(share, *, colors=(0, 0, 0)):
    """Greatest error of three objects on lines, of whose boxes a share is not told [px]."""
    rng, tracker, worst = np.random.default_rng(5), Tracker(), 0.0
    for k in range(60):
        u, v = 40 + np.array([4.0, 3.0, 2.0]) * k, np.array([60.0, 160.0, 260.0])
        rows = np.zeros(3, DETECTION)
        rows['u'], rows['v'] = u + rng.normal(0, 0.5, 3), v + rng.normal(0, 0.5, 3)
        told = rng.random(3) >= share
        rows['box_w'] = rows['box_h'] = SIDES * told
        rows['box_u'], rows['box_v'] = rows['u'] - SIDES / 2 + 0.5, rows['v'] - SIDES / 2 + 0.5
        rows['area'], rows['color'] = SIDES**2 * told, colors
        found = tracker.update(Detections(rows, round((1 + k / 30) * 1e9))).rows
        if k >= 15:
            assert found['track_id'].tolist() == [1, 2, 3]
            worst = max(worst, float(np.hypot(found['u'] - u, found['v'] - v).max()))
    return worst


@pytest.mark.parametrize('share', [0.2, 0.5, 0.8])
def test_an_object_whose_box_is_not_told_is_no_smaller_than_it_was(share):
    assert error(share) == pytest.approx(error(0.0), abs=0.3)


def test_objects_of_another_color_lend_no_size():
    assert error(0.5, colors=(0, 1, 7)) == pytest.approx(error(0.0), abs=0.3)
