import os

import cv2
import numpy as np
import pytest
from support.claims import write_huge_png

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
