"""The color of a detector that nobody has told one: the red of the pictures, by its name."""

import cv2
import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.presets import PRESETS
from colortrack_ros.detection.reference import reference_color_of
from colortrack_ros.detection.reference import ReferenceColorConfig


@pytest.mark.parametrize('tolerance', [0.0, 30.0])
def test_a_color_without_anything_else_is_that_of_its_name(tolerance):
    color = reference_color_of('blue', ReferenceColorConfig(tolerance=tolerance))
    assert color.lab == PRESETS['blue'][0]
    assert color.tolerance == tolerance
    assert color.preset == ('' if tolerance else 'blue')


def test_the_red_of_a_real_thing_is_found_by_default():
    """A tomato before dark skin, which is as near to the red of our scenes."""
    image = np.full((120, 160, 3), (75, 95, 180), np.uint8)
    cv2.circle(image, (60, 60), 20, (40, 20, 170), -1)
    (row,) = Detector(DetectorConfig()).detect(Frame(image)).rows
    assert abs(row['u'] - 60) < 0.5
