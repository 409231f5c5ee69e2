"""Transforms are kept, and those that cannot be of one robot are told, with a buffer as of tf2."""

from geometry_msgs.msg import TransformStamped
import pytest

from colortrack_ros.messages import header_of
from colortrack_ros.node_kit.transform_intake import TransformIntake

STEP = 20_000_000


class Buffer:
    """What tf2_ros.Buffer has of this, which no wheel has."""

    def __init__(self):
        self.kept = []

    def set_transform(self, transform, authority):
        self.kept.append(transform)

    set_transform_static = set_transform

    def clear(self):
        self.kept.clear()


def transform(stamp, x, parent='odom', child='base_footprint'):
    message = TransformStamped(header=header_of(stamp, parent), child_frame_id=child)
    message.transform.translation.x, message.transform.rotation.w = x, 1.0
    return message


@pytest.fixture
def told():
    return []


@pytest.fixture
def intake(told):
    intake = TransformIntake(Buffer(), told.append)
    intake.set_transform_static(transform(0, 0.0, 'base_footprint', 'base_link'), '')
    return intake


def test_a_frame_on_the_way_that_two_nodes_publish_is_told_and_no_other(intake, told):
    for k in range(20):
        intake.set_transform(transform(k * STEP, 0.4 * (k % 2)), '')
        intake.set_transform(transform(k * STEP, 0.01 * k, 'base_link', 'head'), '')
        intake.set_transform(transform(k * STEP, 0.4 * (k % 2), 'base_link', 'hand'), '')
    assert "'base_footprint' goes to and fro by 0.40 m" in intake.rival('base_link', 'odom')
    assert not intake.rival('head', 'base_link')
    assert not intake.rival('unknown', 'odom')
    assert not told


def test_frames_that_are_their_own_parents_are_left_to_tf2(intake):
    intake.set_transform(transform(0, 0.0, 'a', 'b'), '')
    intake.set_transform(transform(0, 0.0, 'b', 'a'), '')
    assert not intake.rival('a', 'odom')


def test_a_run_that_starts_again_is_told_and_forgets_the_last(intake, told):
    for k in (*range(100), *range(20)):
        intake.set_transform(transform(k * STEP, 0.01 * k), '')
    assert told == [
        "TF: the time of 'base_footprint' has gone back by more than 0.5 s: poses start anew"
    ]
    assert len(intake._buffer.kept) == 20
    assert not intake.rival('base_link', 'odom')
