"""Blobs that have the shape of a disc, as the detector gives them."""

import cv2
import numpy as np
import pytest

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.matching import measured_of
from colortrack_ros.world.matching import round_blobs
from colortrack_ros.world.matching import seen_sizes
from colortrack_ros.world.state import Kinds

FINER = 8


def blobs(diameter, tolerance, covered=0.0):
    """Detections of a ball at many places between pixels, covered from a corner of its box on."""
    color = ReferenceColor.from_rgb('red', (205, 58, 34), tolerance)
    detector, rng, found = Detector(DetectorConfig(colors=(color,))), np.random.default_rng(0), []
    for k in range(20):
        u, v = (rng.uniform(40, 80, 2) * FINER).astype(int)
        r = diameter * FINER // 2
        image = np.full((120 * FINER, 120 * FINER, 3), 110, np.uint8)
        cv2.circle(image, (int(u), int(v)), r, (34, 58, 205), -1)
        end = int(2 * r * covered)
        image[v - r : v - r + end, u - r : u - r + end] = 110
        image = cv2.resize(image, (120, 120), interpolation=cv2.INTER_AREA)
        found.append(detector.detect(Frame(image, stamp=k * 33_333_333)).rows)
    return np.concatenate(found)


@pytest.mark.slow
@pytest.mark.parametrize('tolerance', [0.0, 25.0], ids=['found', 'given'])
def test_balls_are_round_whether_their_boxes_are_eroded_or_not_and_corners_are_not(tolerance):
    for diameter in (9, 10, 12, 16, 24, 40):
        rows = blobs(diameter, tolerance)
        assert round_blobs(rows, seen_sizes(rows, LocatorConfig())).all()
    for diameter in (24, 40, 60):
        rows = blobs(diameter, tolerance, covered=0.55)
        assert not round_blobs(rows, seen_sizes(rows, LocatorConfig())).any()


@pytest.mark.parametrize('diameter', [0.2, 0.0])
def test_the_center_of_a_ball_that_something_hides_in_part_is_as_uncertain_as_what_is_hidden(
    diameter,
):
    """24 px are left of 48: its center is 12 px aside. Of what is no ball nobody can say so."""
    row = np.zeros(1, DETECTION)
    row['u'], row['v'], row['box_w'], row['box_h'] = 100, 100, 24, 48
    row['box_u'], row['box_v'], row['area'] = 88, 76, 700
    kind = Kind('red', KindConfig(diameter=diameter, height=0.1))
    config = LocatorConfig(colors=(kind,), pixel_noise=0.0)
    camera = CameraModel.of(640, 480, (520, 0, 320, 0, 520, 240, 0, 0, 1))
    R = measured_of(row, Kinds.of(config), config, camera, None).R[0]
    assert np.sqrt(R[0, 0]) == pytest.approx(12 if diameter else 0)
    assert R[1, 1] == 0
