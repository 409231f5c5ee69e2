"""Boxes of others, as vision_msgs/Detection2DArray, live and from a bag."""

import importlib.util

import numpy as np
import pytest
from rclpy.qos import qos_profile_sensor_data
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2
from support.balls_seen import RADIUS
from support.balls_seen import seen
from support.boxes import box
from support.boxes import serialized
from support.boxes import write_boxes
from support.recorded import of_topic
from support.recorded import tracks_of

from colortrack_ros.messages import BOXES
from colortrack_ros.messages import detections_of_cloud
from colortrack_ros.messages import tracks_of_cloud
from colortrack_ros.node_kit.camera_feed import CameraFeedConfig
from colortrack_ros.node_kit.detections_intake import DetectionsConfig
from colortrack_ros.nodes.locator import LocatorSetup
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.world import CameraModel
from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.view import View

START = 1_700_000_000_000_000_000
CLASSES = ['dog', 'ball']
NO_VISION = 'vision_msgs is in no wheel; a robot has it'


def walk(k: int) -> bytes:
    """A ball that moves by 3 px a frame of 40 ms, a dog that stays, and a chair nobody wants."""
    return serialized(
        [
            box(100.0 + 3 * k, 80.0, 20.0, 20.0, [('ball', 0.8)]),
            box(300.0, 200.0, 60.0, 40.0, [('dog', 0.9), ('ball', 0.1)]),
            box(500.0, 100.0, 50.0, 50.0, [('chair', 0.9)]),
        ],
        START + k * 40_000_000,
    )


def test_a_bag_of_boxes_is_replayed_by_class(replay, tmp_path):
    bag = write_boxes(tmp_path / 'run', '/yolo/detections', {START + k: walk(k) for k in range(20)})
    status, printed, _ = replay(bag, '-p', f'tracker:classes:={CLASSES}')
    assert status == 0
    assert 'detections  40' in printed
    assert "warnings    1 pictures, the last: class 'chair' is left out" in printed
    rows = tracks_of('run_tracks')[-1]
    assert rows['color'].tolist() in ([0, 1], [1, 0])
    (ball,) = rows[rows['color'] == 1]
    assert (ball['u'], ball['du']) == pytest.approx((157, 75), abs=2)
    (first, *_) = of_topic('run_tracks', '/detections')
    found = detections_of_cloud(deserialize_message(first.cdr, PointCloud2)).rows
    assert sorted(found['u'].tolist()) == [100.0, 300.0]


def test_how_sure_a_network_has_to_be_is_a_parameter(replay, tmp_path):
    bag = write_boxes(tmp_path / 'run', '/yolo/detections', {START + k: walk(k) for k in range(9)})
    status, printed, _ = replay(bag, '-p', 'tracker:min_box_score:=0.85')
    assert status == 0
    assert 'detections  18' in printed
    assert 'boxes with scores below 0.85 are left out' in printed


def test_classes_that_are_numbers_need_no_quotes(replay, tmp_path):
    cups = serialized([box(100.0, 80.0, 20.0, 20.0, [('41', 0.8)])], START)
    bag = write_boxes(tmp_path / 'run', '/yolo/detections', {START: cups})
    status, printed, _ = replay(bag, '-p', 'tracker:classes:=[0, 41]')
    assert status == 0
    assert 'detections  1' in printed
    (first, *_) = of_topic('run_tracks', '/detections')
    assert detections_of_cloud(deserialize_message(first.cdr, PointCloud2)).rows['color'] == [1]


def test_a_class_that_is_given_twice_is_refused(replay, tmp_path):
    bag = write_boxes(tmp_path / 'run', '/yolo/detections', {START: walk(0)})
    status, _, told = replay(bag, '-p', 'tracker:classes:=[dog, dog]')
    assert status != 0
    assert "classes: expected each ID once, got ['dog', 'dog']" in told


def test_boxes_are_taken_where_the_tracker_expects_them_though_there_are_pictures(
    replay, bag, tmp_path
):
    status, _, told = replay(bag, '-p', f'tracker:detections_type:={BOXES}')
    assert status != 0
    assert f'no topic /detections there, nor another of {BOXES}; there is' in told


def test_a_ball_in_the_box_of_a_network_is_located_by_its_size():
    ball = Kind('ball', KindConfig(diameter=2 * RADIUS))
    feed = CameraFeedConfig(detections=DetectionsConfig(detections_type=BOXES))
    setup = LocatorSetup(config=LocatorConfig(colors=(ball,), method='size'), feed=feed)
    locator, tracker = Locator(setup.seen_as, pytest.fail), Tracker(TrackerConfig())
    camera = CameraModel.of(640, 480, (500, 0, 320, 0, 500, 240, 0, 0, 1), ())
    view = View(camera, Pose.of_rpy((0, 0, 0), (0, 0, 0)), Pose.of_rpy((0, 0, 0.5), (0, 0.2, 0)))
    for k in range(20):
        stamp = START + k * 40_000_000
        (blob,) = seen(view, (2.0, 0.3, RADIUS), stamp)[1].rows
        side = float(blob['box_w']) + LocatorConfig.eroded
        boxes = serialized([box(float(blob['u']), float(blob['v']), side, side)], stamp)
        detections = setup.feed.detections.reader(pytest.fail)(boxes)
        (found,) = locator.update(tracker.update(detections), detections, view).rows
    assert (found['x'], found['y'], found['z']) == pytest.approx((2.0, 0.3, RADIUS), abs=0.02)


@pytest.mark.skipif(importlib.util.find_spec('vision_msgs') is not None, reason='it is installed')
def test_a_node_that_cannot_know_boxes_says_what_to_install(ros):
    node = ros.start('tracker', detections_type=BOXES)
    node.wait_for('vision_msgs is not installed: sudo apt install ros-jazzy-vision-msgs')
    assert node.popen.wait(20) == 1


def test_the_tracker_follows_the_boxes_of_a_network(ros):
    vision = pytest.importorskip('vision_msgs.msg', reason=NO_VISION)
    node = ros.start(
        'tracker', detections_type=BOXES, detections_topic='yolo/detections', classes=CLASSES
    )
    tracks = ros.listen(PointCloud2, 'tracks')
    publisher = ros.node.create_publisher(
        vision.Detection2DArray, 'yolo/detections', qos_profile_sensor_data
    )
    assert ros.spin(lambda: publisher.get_subscription_count() == 1)
    ros.settle()
    for k in range(20):
        publisher.publish(deserialize_message(walk(k), vision.Detection2DArray))
        assert ros.spin(lambda k=k: len(tracks) == k + 1), ros.outputs()
    rows = tracks_of_cloud(tracks[-1]).rows
    assert sorted(rows['color'].tolist()) == [0, 1]
    np.testing.assert_allclose(sorted(rows['u']), [157, 300], atol=1)
    node.wait_for("class 'chair' is left out")


def test_a_tracker_that_expects_other_messages_names_the_parameter(ros):
    vision = pytest.importorskip('vision_msgs.msg', reason=NO_VISION)
    ros.node.create_publisher(vision.Detection2DArray, 'detections', 10)
    ros.start('tracker').wait_for(f'not {BOXES}, see detections_type')
