"""What is cut out of a picture to be described."""

import cv2
import numpy as np
import pytest
from support.window_pictures import frame
from support.window_pictures import texture

from colortrack_ros.data import Frame
from colortrack_ros.windows.appearance import Appearance
from colortrack_ros.windows.features import cut

PICTURE = np.random.default_rng(0).integers(0, 256, (60, 80, 3), dtype=np.uint8)
MARGIN = 200
AROUND = cv2.copyMakeBorder(PICTURE, *4 * [MARGIN], cv2.BORDER_REPLICATE)


@pytest.mark.parametrize('times', [1, 2, 4])
@pytest.mark.parametrize('center', [(40.0, 30.0), (40.5, 30.3), (1.2, 58.9), (-30.0, 200.0)])
def test_a_part_is_of_whole_pixels_and_says_where_it_is(center, times):
    """Outside the picture its border is repeated, and pixels are averaged where some would be
    skipped."""
    wanted = np.array([24.2, 31.7])
    part = cut(Frame(PICTURE, 'bgr8', 0), np.array(center), wanted, 1.5 * times)
    assert part.times == times
    assert np.abs(part.center - center).max() <= (0.5 if times > 1 else 0.25)
    assert np.abs(part.size - wanted).max() <= max(1.5, times / 2)
    left, top = (part.center - (part.size - 1) / 2 + MARGIN).tolist()
    assert left.is_integer()
    assert top.is_integer()
    width, height = part.size.tolist()
    whole = AROUND[int(top) : int(top) + height, int(left) : int(left) + width].astype(float)
    means = whole.reshape(height // times, times, width // times, times, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(part.pixels, means, atol=1.01)  # rounded once or twice


def test_a_place_is_found_as_exactly_wherever_it_is_looked_for():
    picture = 0.4 * texture(30, 240, 320) + 70
    picture[105:136, 145:176] = texture(31, 31, 31)
    target = Appearance(frame(picture), np.array([160.0, 120.0]), np.array([31.0, 31.0]))
    for beside in [(0.0, 0.0), (0.2, -0.2), (0.45, 0.3), (-0.7, 0.6)]:
        seen = target.look(frame(picture), np.add((160, 120), beside))
        assert seen.z == pytest.approx((160, 120), abs=0.15)
