"""What the tuner shows of the colors of a picture."""

import cv2
import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.growth import NEAR
from colortrack_ros.tuner.measures import plane_of


@pytest.mark.slow
def test_a_name_stands_for_what_is_none_of_the_other_colors_as_it_does_for_the_detector():
    red, crimson = (200, 60, 40), (215, 20, 80)
    image = np.full((120, 200, 3), (190, 190, 180), np.uint8)
    cv2.circle(image, (60, 60), 40, red[::-1], cv2.FILLED)
    cv2.circle(image, (150, 60), 20, crimson[::-1], cv2.FILLED)
    ball, name = ReferenceColor.from_rgb('ball', red, 20.0), ReferenceColor.from_preset('x', 'red')
    for colors, shown in (((name,), red), ((ball, name), crimson), ((name, ball), crimson)):
        place = plane_of(Frame(image), DetectorConfig(colors=colors))['colors'][colors.index(name)]
        lab = ReferenceColor.from_rgb('shown', shown).lab
        assert np.linalg.norm(np.subtract(place['samples'][0], lab)) < NEAR
