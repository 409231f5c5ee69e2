"""How far a color reaches of which the picture has few pixels."""

import numpy as np
import pytest

from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.extent import sample_colors
from colortrack_ros.detection.small_color import small_extent

RED, WALL = (200, 40, 35), (120, 120, 120)


@pytest.mark.parametrize(('width', 'is_small'), [(4, True), (120, False)])
def test_few_pixels_are_of_small_things_and_many_are_of_the_ground(width, is_small):
    """Of a ground, each picture would be searched for things."""
    image = np.full((120, 160, 3), WALL, np.uint8)
    image[40 : 40 + width, :width] = RED
    _, counts = sample_colors(image, 'rgb8')
    found = small_extent(counts, ReferenceColor.from_rgb('it', RED, 0.0), (), None)
    assert (found is not None) == is_small
