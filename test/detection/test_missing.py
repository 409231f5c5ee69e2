"""Why a color is not found is told truly."""

import cv2
import numpy as np

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor

RED = (200, 40, 35)


def trouble(image):
    """What is told after 3 s of pictures in which red without a tolerance is not found."""
    detector = Detector(DetectorConfig(colors=(ReferenceColor.from_rgb('red', RED, 0.0),)))
    for k in range(4):
        assert len(detector.detect(Frame(image, 'rgb8', k * NANOSECONDS)).rows) == 0
    return detector.trouble


def two_small_balls():
    """Red ones, 5 px wide, before a noisy wall."""
    image = np.full((120, 160, 3), 130.0)
    for center in ((40, 60), (110, 40)):
        cv2.circle(image, center, 2, RED, cv2.FILLED)
    image = cv2.GaussianBlur(image, (0, 0), 0.7) + np.random.default_rng(1).normal(
        0, 2, image.shape
    )
    return image.clip(0, 255).astype(np.uint8)


def test_things_that_are_too_small_are_not_said_to_be_absent_and_what_is_told_finds_them():
    image = two_small_balls()
    assert 'px of the picture, too few to find how far it extends' in trouble(image)
    color = ReferenceColor.from_rgb('red', RED, 40.0)
    told = DetectorConfig(colors=(color,), erosion_size=1, min_area=4)
    assert len(Detector(told).detect(Frame(image, 'rgb8')).rows) == 2


def test_a_shaded_ball_of_another_color_is_not_said_to_be_one_that_is_too_small():
    v, u = np.mgrid[-60:60, -80:80] / 8
    light = np.sqrt(np.maximum(1 - u * u - v * v, 0))[..., None]
    image = np.where(light > 0, np.array([200, 90, 60]) * (0.35 + 0.65 * light), 120.0)
    image += np.random.default_rng(1).normal(0, 4, image.shape)
    assert 'red has not been seen yet' in trouble(image.clip(0, 255).astype(np.uint8))
