"""Pictures without pixels, as drivers may send while they start."""

import cv2
import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.windows import WindowTracker


@pytest.mark.slow
@pytest.mark.parametrize('encoding', ['bgr8', 'mono8'])
@pytest.mark.parametrize('shape', [(0, 0), (0, 320), (240, 0)])
def test_a_picture_without_pixels_shows_nothing_and_drops_no_target(encoding, shape):
    room = np.random.default_rng(0).uniform(0, 255, (240, 320, 3)).astype(np.uint8)
    room = cv2.normalize(cv2.GaussianBlur(room, (0, 0), 3), None, 0, 255, cv2.NORM_MINMAX)
    pictures = [room if encoding == 'bgr8' else room[..., 0]] * 12
    pictures[5] = pictures[6] = np.zeros((*shape, *pictures[0].shape[2:]), np.uint8)
    tracker = WindowTracker()
    tracker.start([[100, 100, 40, 40]])
    shown = [
        tracker.update(Frame(picture, encoding, NANOSECONDS + k * NANOSECONDS // 30)).rows
        for k, picture in enumerate(pictures)
    ]
    assert [rows['track_id'].tolist() for rows in shown] == [[1]] * 5 + [[]] * 2 + [[1]] * 5
