"""Things whose color lies between two of those that are looked for."""

import numpy as np
import pytest
from support.cameras import encode

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor

ORANGE, YELLOW, RED = (235, 130, 35), (225, 190, 50), (200, 60, 40)
COLORS = tuple(
    ReferenceColor.from_rgb(name, rgb, 30.0)
    for name, rgb in (('orange', ORANGE), ('yellow', YELLOW), ('red', RED))
)


def balls(*placed, noise=0.0, size=(120, 320)):
    """A frame with balls (u, v, radius, rgb), lit from the upper left, in front of a gray wall."""
    image = np.full((*size, 3), 150.0)
    v, u = np.indices(size)
    for center_u, center_v, radius, rgb in placed:
        inside = np.hypot(u - center_u, v - center_v) <= radius
        light = 1 - 0.18 * ((u - center_u) + (v - center_v)) / radius
        image[inside] = light[inside, None] * rgb
    image += np.random.default_rng(0).normal(0, noise, image.shape)
    return Frame(np.clip(image, 0, 255).astype(np.uint8), 'rgb8')


def detected(frame, colors=COLORS):
    return Detector(DetectorConfig(colors=colors, min_area=4)).detect(frame).rows


@pytest.mark.parametrize('noise', [3.0, 8.0])
@pytest.mark.parametrize('rgb', [(230, 160, 42), (205, 135, 40), (215, 100, 38)])
def test_a_ball_between_two_colors_is_one_whole_blob_of_one_of_them(rgb, noise):
    rows = detected(balls(*((30 + 60 * k, 60, 6.0, rgb) for k in range(5)), noise=noise))
    alone = detected(balls((30, 60, 6.0, ORANGE)))['area'][0]
    assert len(rows) == 5
    assert (rows['area'] > 0.7 * alone).all()


def test_balls_of_two_colors_that_touch_stay_two():
    rows = detected(balls((60, 60, 12.0, ORANGE), (84, 60, 12.0, YELLOW), noise=3.0))
    assert sorted(rows['color'].tolist()) == [0, 1]
    np.testing.assert_allclose(np.sort(rows['u']), [60, 84], atol=1.5)


def test_what_lies_on_a_ground_does_not_become_what_is_not_the_ground():
    ground = ReferenceColor.from_rgb('else', (150, 150, 150), 20.0)
    ground = ReferenceColor('else', ground.lab, 20.0, inverted=True)
    frame = balls((100, 60, 30.0, (40, 60, 200)), (100, 60, 12.0, ORANGE))
    colors = (ground, *COLORS)
    assert detected(frame, colors)['color'].tolist() == [0, 1]


def test_colors_that_are_close_but_do_not_touch_are_read_in_yuv_too():
    image = np.full((16, 48, 3), 150, np.uint8)
    image[4:12, :8], image[4:12, 16:24] = ORANGE[::-1], YELLOW[::-1]
    assert sorted(detected(encode(image, 'yuyv'))['color']) == [0, 1]
