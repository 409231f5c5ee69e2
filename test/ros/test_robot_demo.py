"""All of the world of a robot at once: nodes that see, locate and follow, each its own process."""

import os
import re
import subprocess
import sys

import cv2
import pytest
from support.ros_domain import free_domain
from support.waiting import PATIENCE


@pytest.mark.slow
def test_the_robot_keeps_its_distance_to_the_ball_and_leaves_a_video(tmp_path):
    domain, lock = free_domain()
    command = [sys.executable, '-m', 'colortrack_ros.tools.robot_demo', '--seconds', '3']
    done = subprocess.run(
        [*command, '--out', str(tmp_path)],
        env=dict(os.environ, ROS_DOMAIN_ID=str(domain), COLUMNS='120'),
        capture_output=True,
        text=True,
        timeout=2 * PATIENCE,
    )
    lock.close()
    assert done.returncode == 0, done.stderr
    said = re.search(r'(\d+) pictures in 3 s; median distance to the ball (\S+) m', done.stdout)
    assert said, done.stdout
    # it begins 1.2 m behind the ball, which would be 2.4 m away by then
    assert float(said[2]) < 1.7
    video = cv2.VideoCapture(str(tmp_path / 'demo.mp4'))
    assert video.get(cv2.CAP_PROP_FRAME_COUNT) == int(said[1])
    assert video.read()[1].shape == (480, 1280, 3)
