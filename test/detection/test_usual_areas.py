"""What suddenly fills the picture with a color is none of its objects, nor the measure of them."""

import cv2
import numpy as np

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor

RED, GRAY = (200, 40, 40), (120, 130, 125)


def detections(*pictures, rate=25):
    """Detections of red in each picture."""
    detector = Detector(DetectorConfig(colors=(ReferenceColor.from_rgb('red', RED),)))
    return [
        detector.detect(Frame(picture, 'rgb8', k * NANOSECONDS // rate)).rows
        for k, picture in enumerate(pictures)
    ]


def numbers(*pictures):
    """Number of detections of red in each picture."""
    return [len(rows) for rows in detections(*pictures)]


def ball(radius, at=(160, 120)):
    image = np.full((240, 320, 3), GRAY, np.uint8)
    return cv2.circle(image, at, radius, RED, cv2.FILLED)


def test_a_ball_is_still_found_when_a_red_wall_has_filled_the_picture():
    """It was taken for a speck of what is as large as the wall, for up to three seconds."""
    wall = np.full((240, 320, 3), RED, np.uint8)
    found = numbers(*[ball(12)] * 25, *[wall] * 3, *[ball(12)] * 25)
    assert found == [1] * 25 + [0] * 3 + [1] * 25


def test_a_ball_that_comes_near_may_fill_it():
    assert numbers(*(ball(12 + 4 * k) for k in range(30))) == [1] * 30


def test_what_fills_it_and_stays_is_an_object_though_a_speck_of_its_color_stays_too():
    """The speck was the measure of it forever."""
    speck = ball(6, at=(20, 20))
    both = cv2.circle(speck.copy(), (160, 120), 90, RED, cv2.FILLED)
    found = detections(*[speck] * 25, *[both] * 100)
    assert [rows['u'].round().tolist() for rows in found[25:]] == [[20]] * 74 + [[160]] * 26
