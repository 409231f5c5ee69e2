"""What turns is where its blob is, though its box changes and its centroid is off the middle."""

import cv2
import numpy as np
import pytest
from support.silhouettes import blobs_of

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking import Tracker

OUTLINE = np.array([[-300, -20], [300, -6], [300, 6], [-300, 20]], float)
"""Corners of a bar that is thicker at one end [px]."""


def seen_of(corners, stamp):
    """Detections of the polygon with these corners, (K, 2) [px], as its pixels say."""
    mask = np.zeros((800, 1400), np.uint8)
    cv2.fillPoly(mask, [np.round(16 * corners).astype(np.int32)], 1, shift=4)
    return blobs_of(mask, stamp)


@pytest.mark.slow
@pytest.mark.parametrize('spin', [1.0, 1.5, 2.0])
@pytest.mark.parametrize('tumble', [0.0, 0.5, 1.5])
def test_a_bar_that_turns_is_not_taken_for_one_that_is_cut(spin, tumble):
    """Its centroid is not in the middle of its box, whose sides both come in and go out again.

    :param spin: in the plane of the picture, tumble: out of it [rad/s].
    """
    tracker, away, sigma, ids = Tracker(), [], [], set()
    for k in range(150):
        s = k / 30
        cosine, sine = np.cos(spin * s), np.sin(spin * s)
        outline = OUTLINE * [max(abs(np.cos(tumble * s)), 0.08), 1]
        corners = outline @ [[cosine, sine], [-sine, cosine]] + [500 + 60 * s, 400]
        seen = seen_of(corners, k * NANOSECONDS // 30)
        rows = tracker.update(seen).rows
        rows = rows[rows['state'] > 0]
        ids.update(rows['track_id'].tolist())
        for row in rows:
            e = np.array([row['u'] - seen.rows['u'][0], row['v'] - seen.rows['v'][0]])
            away.append(np.hypot(*e))
            sigma.append(np.sqrt(e @ np.linalg.solve(row['covariance'][:2, :2], e)))
    assert len(ids) == 1
    assert max(away) < 50, 'of 600 px'
    assert max(sigma) < 5
