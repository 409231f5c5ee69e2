import os

import cv2
import numpy as np
import pytest
from support.claims import write_huge_png

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.regions import Region
from colortrack_ros.detection.regions import Regions


def test_a_mask_is_read_from_its_file(tmp_path):
    path = str(tmp_path / 'mask.png')
    cv2.imwrite(path, np.zeros((4, 5), np.uint8))
    assert Regions((), path)
    assert not Regions((), '')


@pytest.mark.parametrize('name', ['huge.png', 'text.png', 'empty.png', 'pipe.png', 'missing', '.'])
def test_what_is_no_picture_is_refused_by_name(tmp_path, name):
    write_huge_png(tmp_path / 'huge.png')
    (tmp_path / 'text.png').write_text('no picture')
    (tmp_path / 'empty.png').touch()
    os.mkfifo(tmp_path / 'pipe.png')
    with pytest.raises(ValueError, match=r'^mask: expected the path of a picture'):
        Regions((), str(tmp_path / name))


SQUARE = np.array([(0.1, 0.1), (0.9, 0.1), (0.9, 0.9), (0.1, 0.9)])


@pytest.mark.parametrize(
    ('corners', 'ignore', 'left'),
    [
        (SQUARE, False, 4),  # shares of the picture
        (1000 + 100 * SQUARE, False, 0),  # of larger pictures
        (1000 * (SQUARE - 0.1), True, 0),
        (100 * SQUARE, False, None),
        (1000 + 100 * SQUARE, True, None),
    ],
)
def test_regions_that_leave_nothing_to_look_in_are_told(corners, ignore, left):
    """Nothing was found, without a word."""
    regions = (Region('a', tuple(map(tuple, corners.tolist())), ignore),)
    detector = Detector(DetectorConfig(regions=regions, min_area=1))
    assert detector.trouble == ''
    detector.detect(Frame(np.full((120, 160, 3), 130, np.uint8)))
    told = f'regions and mask leave {left} of the 160x120 pixels to look in: expected corners in'
    assert detector.trouble.startswith(told) if left is not None else detector.trouble == ''
