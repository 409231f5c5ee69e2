import numpy as np
import pytest

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import pick_color
from colortrack_ros.detection import side_by_side
from colortrack_ros.scenes import open_scene


@pytest.fixture(scope='module')
def clutter():
    scene = open_scene('clutter')
    return Frame(scene.render(60)), scene.truth(60)


def test_the_color_picked_from_a_shaded_ball_finds_that_ball(clutter):
    frame, truth = clutter
    for ball in truth:
        picked = pick_color(frame, int(ball['u']) + 4, int(ball['v']) - 3, name='ball')
        assert picked.color.name == 'ball'
        assert picked.area == pytest.approx(np.pi * (ball['radius'] - 1) ** 2, rel=0.25)
        rows = Detector(DetectorConfig(colors=(picked.color,))).detect(frame).rows
        distance = np.hypot(rows['u'] - ball['u'], rows['v'] - ball['v'])
        assert distance.min() < 1
        assert len(rows) <= 6, 'the furniture of this color, but no noise'


def test_in_a_picture_of_one_color_that_color_is_picked():
    frame = Frame(np.full((20, 30, 3), (34, 58, 205), np.uint8))
    picked = pick_color(frame, 0, 19)
    assert picked.color.lab == pytest.approx((47.1, 56.5, 47.1), abs=0.1)
    assert picked.area == 600


@pytest.mark.parametrize('pixel', [(-1, 0), (30, 0), (0, 20)])
def test_a_pixel_outside_of_the_picture_is_refused(pixel):
    with pytest.raises(ValueError, match=r'pixel: expected u, v in the picture of 30 x 20 px, got'):
        pick_color(Frame(np.zeros((20, 30, 3), np.uint8)), *pixel)


@pytest.mark.parametrize('encoding', ENCODINGS)
def test_picture_mask_and_blobs_are_shown_side_by_side(encoding):
    frame = Frame(np.zeros((20, 30, ENCODINGS[encoding]), np.uint8), encoding)
    assert side_by_side(frame, Detector(DetectorConfig())).shape == (20, 90, 3)
