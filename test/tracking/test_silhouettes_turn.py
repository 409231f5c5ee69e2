"""What turns is where its blob is, though its box changes and its centroid is off the middle."""

import cv2
import numpy as np
import pytest

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking import Tracker

OUTLINE = np.array([[-300, -20], [300, -6], [300, 6], [-300, 20]], float)
"""Corners of a bar that is thicker at one end [px]."""


def detection(corners):
    """A detection of the polygon with these corners, (K, 2) [px], as its pixels say."""
    picture = np.zeros((800, 1400), np.uint8)
    cv2.fillPoly(picture, [np.round(16 * corners).astype(np.int32)], 1, shift=4)
    v, u = picture.nonzero()
    rows = np.zeros(1, DETECTION)
    rows['u'], rows['v'], rows['area'] = u.mean(), v.mean(), len(u)
    rows['box_u'], rows['box_v'] = u.min(), v.min()
    rows['box_w'], rows['box_h'] = np.ptp(u) + 1, np.ptp(v) + 1
    rows['cov_uu'] = rows['cov_vv'] = 0.3
    return rows


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
        seen = detection(outline @ [[cosine, sine], [-sine, cosine]] + [500 + 60 * s, 400])
        rows = tracker.update(Detections(seen, k * NANOSECONDS // 30)).rows
        rows = rows[rows['state'] > 0]
        ids.update(rows['track_id'].tolist())
        for row in rows:
            e = np.array([row['u'] - seen['u'][0], row['v'] - seen['v'][0]])
            away.append(np.hypot(*e))
            sigma.append(np.sqrt(e @ np.linalg.solve(row['covariance'][:2, :2], e)))
    assert len(ids) == 1
    assert max(away) < 50, 'of 600 px'
    assert max(sigma) < 5
