"""Pure colors on plain grounds, as programs draw them."""

import cv2
import numpy as np
import pytest

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Frame


@pytest.mark.slow
@pytest.mark.parametrize('color', [(0, 0, 255), (0, 255, 0), (0, 255, 255), (0, 0, 0)])
def test_a_disc_of_a_pure_color_on_white_has_edges(color):
    """Its largest channel is that of white; it was lost at once."""
    tracker = ContourTracker(ContourConfig(start='targets'))
    tracker.start([[45, 45, 31, 31]])
    for k in range(40):
        picture = np.full((240, 320, 3), 255, np.uint8)
        cv2.circle(picture, (60 + 3 * k, 60 + k), 15, color, -1)
        (row,) = tracker.update(Frame(picture, 'bgr8', round(k * 1e9 / 30))).rows
        assert np.hypot(row['u'] - 60 - 3 * k, row['v'] - 60 - k) < 0.3
    assert row['state'] == CONFIRMED
    assert row['area'] == pytest.approx(709, rel=0.05)
