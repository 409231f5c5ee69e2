"""Pictures that lose their color, or get one."""

from dataclasses import replace

import cv2
from support.window_pictures import frame
from support.window_pictures import texture

from colortrack_ros.windows import WindowTracker


def test_pictures_that_lose_their_color_or_get_one_start_the_targets_afresh():
    """Templates of color were compared with gray levels, which raised ValueError."""
    tracker = WindowTracker(targets=[[45.0, 35.0, 31.0, 31.0]])
    for k, is_gray in enumerate([False] * 3 + [True] * 3 + [False] * 2):
        gray = frame(texture(3), k)
        color = replace(gray, image=cv2.merge([gray.image] * 3), encoding='bgr8')
        tracks = tracker.update(gray if is_gray else color)
        assert tracks.rows['track_id'].tolist() == [1 + k // 3]
        told = {3: 'from color to gray', 6: 'from gray to color'}
        assert tracks.restarted.removeprefix('the pictures changed ') == told.get(k, '')
