"""Boxes that wait for the next frame."""

import numpy as np

from colortrack_ros.estimation.waiting_boxes import WaitingBoxes

FIRST, SECOND, DETECTED = [[1, 2, 30, 40]], [[5, 6, 30, 40]], [[7, 8, 9, 10]]


def test_targets_named_again_before_a_picture_has_come_replace_those_that_wait():
    waiting = WaitingBoxes(FIRST)
    waiting.add(DETECTED, offered=True)
    waiting.name(SECOND)
    boxes, offered = waiting.take()
    np.testing.assert_array_equal(boxes, SECOND + DETECTED)
    assert offered.tolist() == [False, True]
    waiting.restart()
    np.testing.assert_array_equal(waiting.take()[0], SECOND)
