"""Faults in the threads of nodes that give pictures."""

import pytest
from sensor_msgs.msg import Image

import colortrack_ros

SOURCE = 'scene:single?width=320&height=240'

FAILS_ONCE = """
import sys
from colortrack_ros.nodes import {node}

made, calls = {node}.image_of_frame, []

def fail_once(frame):
    calls.append(frame)
    return made(frame) if len(calls) != 3 else 1 // 0

{node}.image_of_frame = fail_once
sys.exit({node}.main())
"""


@pytest.mark.parametrize('node', ['camera', 'simulator'])
def test_what_fails_with_one_picture_is_told_and_the_next_one_is_published(ros, node):
    images = ros.listen(Image, 'camera/image_raw')
    source = {'source': SOURCE, 'loop': 'true'} if node == 'camera' else {}
    process = ros.start_code(FAILS_ONCE.format(node=node), **source)
    told = ros.spin(lambda: 'please report it: ZeroDivisionError' in process.output)
    assert told, ros.outputs()
    count = len(images)
    assert ros.spin(lambda: len(images) > count + 10), ros.outputs()
    assert process.output.count('ZeroDivisionError') == 1
    assert process.stop() == 0


def test_nodes_that_tests_start_are_of_the_package_that_is_tested(ros):
    """With PYTHONPATH=. those that are forked in another folder were those that are installed."""
    process = ros.start_code('import colortrack_ros; print(colortrack_ros.__file__)', patient=False)
    assert process.end() == 0
    assert process.output.strip() == colortrack_ros.__file__
