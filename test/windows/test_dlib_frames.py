"""A juice carton on a table, seen by a moving camera."""

import cv2
import numpy as np
import pytest
from support.paths import DATA

from colortrack_ros.data import COASTING
from colortrack_ros.data import Frame
from colortrack_ros.windows import WindowTracker

FRAMES = sorted((DATA / 'dlib_frames').glob('*.jpg'))
CENTERS = {15: (149, 168), 45: (151, 82), 75: (179, 103), 120: (77, 131), 150: (252, 120)}
"""Of the carton, read from the pictures [px]."""


@pytest.mark.slow
@pytest.mark.skipif(not FRAMES, reason=f'no pictures at {DATA}; set COLORTRACK_DATA')
def test_the_carton_is_kept_from_the_first_frame_to_the_last():
    assert len(FRAMES) > max(CENTERS)
    tracker = WindowTracker(targets=[93 - 18.5, 110 - 42.5, 38, 86])
    for k, path in enumerate(FRAMES):
        image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        (row,) = tracker.update(Frame(image, 'mono8', k * 33_333_333)).rows
        assert row['state'] != COASTING
        if k in CENTERS:
            assert np.hypot(row['u'] - CENTERS[k][0], row['v'] - CENTERS[k][1]) < 6
