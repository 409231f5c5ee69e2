"""The pictures of a bag in the tuner."""

import numpy as np
import pytest
from support.recorded import frames
from support.recorded import write_bag

from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError
from colortrack_ros.tuner.opening import open_footage
from colortrack_ros.tuner.running import RunningNodes

SCENE = 'scene:single?width=80&height=60&duration=1'


def test_the_frames_of_a_bag_have_their_numbers_and_stamps(tmp_path):
    start = 10**18
    bag = write_bag(tmp_path / 'bag', {'/eye/image_raw': frames(SCENE, start)})
    footage = open_footage(str(bag), RunningNodes())
    expected = list(open_source(SCENE))
    for number in (0, 9, 2):
        assert np.array_equal(footage.frame(number).image, expected[number].image)
        assert footage.frame(number).stamp == start + expected[number].stamp
    assert footage.total == len(expected)
    assert footage.rate == pytest.approx(24.0, abs=0.1)
    footage.close()


def test_of_a_bag_with_several_topics_one_has_to_be_chosen(tmp_path):
    pictures = frames(SCENE)[:2]
    bag = write_bag(tmp_path / 'bag', {'/left': pictures, '/right': pictures})
    with pytest.raises(SourceError, match='--topic may choose'):
        open_footage(str(bag), RunningNodes())
    assert open_footage(str(bag), RunningNodes(), topic='/left').total == 2
