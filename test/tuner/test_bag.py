"""The pictures of a bag in the tuner."""

import contextlib

import numpy as np
import pytest
from support.damaged import damaged_video
from support.open_files import nothing_left_open
from support.recorded import frames
from support.recorded import short_bag
from support.recorded import write_bag

from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError
from colortrack_ros.tuner.folder import Folder
from colortrack_ros.tuner.opening import open_footage
from colortrack_ros.tuner.running import RunningNodes
from colortrack_ros.tuner.session import Session

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
    with nothing_left_open():
        with pytest.raises(SourceError, match='--topic may choose'):
            open_footage(str(bag), RunningNodes())
        with contextlib.closing(open_footage(str(bag), RunningNodes(), topic='/left')) as footage:
            assert footage.total == 2


@pytest.mark.parametrize('kind', ['bag', 'video'])
def test_pictures_that_cannot_be_read_are_told_to_all_users(tmp_path, kind):
    if kind == 'bag':
        path = short_bag(tmp_path / 'bag', {'/eye/image_raw': frames(SCENE)})
        told = 'metadata.yaml tells of 29 messages on /eye/image_raw, 24 were read'
    else:
        path, told = damaged_video(tmp_path / 'damaged.mp4', 'mp4v'), 'cannot be read'
    running = RunningNodes()
    session = Session(open_footage(str(path), running), Folder(tmp_path), running)
    assert not session.state()['trouble']
    session.do('seek', {'frame': 10_000})
    assert told in session.state()['trouble']
