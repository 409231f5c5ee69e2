"""A camera that would look up by TF is probably one whose frame is not the optical one."""

import numpy as np
import pytest

from colortrack_ros.node_kit.camera_pose import looks_up
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose


@pytest.mark.parametrize('rpy', [(0, 0, 0), (0, 0.6, 0), (0.3, -0.5, 2.0), (0, 0.2, np.pi)])
def test_the_body_of_a_camera_looks_up_and_its_optical_frame_does_not(rpy):
    body = Pose.of_rpy((0.1, 0, 0.5), rpy)
    line = looks_up('front_camera_link', body)
    assert "z of camera_frame 'front_camera_link' points up" in line
    assert line.endswith('front_camera_optical_frame')
    assert looks_up('front_camera_optical_frame', body @ OPTICAL) == ''


@pytest.mark.parametrize('pitch', [np.pi / 2, -0.7])
def test_cameras_that_look_down_or_a_little_up_are_right(pitch):
    assert looks_up('cam', Pose.of_rpy((0, 0, 1), (0, pitch, 0)) @ OPTICAL) == ''
