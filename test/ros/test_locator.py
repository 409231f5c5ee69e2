from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray
from geometry_msgs.msg import PoseStamped
from geometry_msgs.msg import PoseWithCovarianceStamped
import numpy as np
import pytest
from rclpy.qos import DurabilityPolicy
from rclpy.qos import QoSProfile
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import PointCloud2
from support.ball_before_camera import BALL
from support.ball_before_camera import info
from support.ball_before_camera import picture
from support.ball_before_camera import PLACE
from support.ball_before_camera import START
from support.locating_robot import FRAME
from support.locating_robot import RED
from support.locating_robot import Robot
from visualization_msgs.msg import MarkerArray

from colortrack_ros.messages import header_of
from colortrack_ros.messages import locations_of_cloud


def test_each_picture_of_a_driving_robot_gives_the_objects_in_odom(ros):
    robot = Robot(ros)
    poses, targets = ros.listen(PoseArray, 'poses'), ros.listen(PoseStamped, 'target_pose')
    certain = ros.listen(PoseWithCovarianceStamped, 'target_pose_with_covariance')
    markers = ros.listen(MarkerArray, 'locations/markers')
    ros.settle()
    for k in range(10):
        robot.drive(k)
        robot.see(k)
        assert ros.spin(lambda k=k: len(robot.locations) == k + 1), ros.outputs()
    assert [m.header for m in robot.locations] == [
        header_of(START + k * FRAME, 'odom') for k in range(10)
    ]
    (row,) = locations_of_cloud(robot.locations[-1]).rows
    assert row['track_id'] == 7
    assert (row['x'], row['y'], row['z']) == pytest.approx(BALL, abs=0.01)
    assert ros.spin(lambda: len(poses) == len(targets) == len(certain) == len(markers) == 10)
    assert targets[-1].pose.position.x == pytest.approx(row['x'])
    assert 'Refused' not in robot.node.output


def test_a_calibration_that_was_sent_once_before_the_node_came_is_heard(ros):
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    ros.node.create_publisher(CameraInfo, 'camera/camera_info', kept).publish(info(START))
    robot = Robot(ros, patient=True)  # with another publisher, which sends nothing
    robot.drive(0)
    for publisher, cloud in zip((robot.detections, robot.tracks), picture(START, 0.0), strict=True):
        publisher.publish(cloud)
    assert ros.spin(lambda: len(robot.locations) == 1), ros.outputs()
    assert len(locations_of_cloud(robot.locations[0]).rows) == 1
    diagnostics.clear()
    assert ros.spin(lambda: len(diagnostics) > 1)
    assert not any('gets nothing' in s.message for m in diagnostics for s in m.status)


def test_two_cameras_that_stand_in_the_room_see_one_ball(ros):
    """They have no odometry; each has its own topics, place and track IDs."""
    place = str([float(number) for number in PLACE])
    node = ros.start(
        'locator', colors='[red]', pose_source='fixed', cameras='[left, right]',
        **{'red.diameter': 0.2, 'left.camera_pose': place, 'right.camera_pose': place},
    )  # fmt: skip
    locations = ros.listen(PointCloud2, 'locations')
    make = ros.node.create_publisher
    topics = {'camera/camera_info': CameraInfo, 'detections': PointCloud2, 'tracks': PointCloud2}
    cameras = [
        [make(kind, f'{name}/{topic}', 10) for topic, kind in topics.items()]
        for name in ('left', 'right')
    ]
    every = [publisher for camera in cameras for publisher in camera]
    assert ros.spin(lambda: all(p.get_subscription_count() for p in every)), ros.outputs()
    assert ros.spin(lambda: ros.node.count_publishers('locations') == 1)
    ros.settle()
    for lens, _, _ in cameras:
        lens.publish(info(START))
    ros.settle()
    for k in range(6):
        _, detections, tracks = cameras[k % 2]
        seen, tracked = picture(START + k * FRAME, 0.0)
        detections.publish(seen)
        tracks.publish(tracked)
        assert ros.spin(lambda k=k: len(locations) == k + 1), ros.outputs()
    assert [locations_of_cloud(m).rows['track_id'].tolist() for m in locations] == [[1]] * 6
    (row,) = locations_of_cloud(locations[-1]).rows
    assert (row['x'], row['y'], row['z']) == pytest.approx(BALL, abs=0.01)
    assert 'Refused' not in node.output


def test_late_odometry_is_waited_for(ros):
    robot = Robot(ros, patient=True)
    robot.drive(0)
    robot.see(1)
    ros.spin(lambda: False, 0.3)
    assert robot.locations == []
    robot.drive(2)
    assert ros.spin(lambda: len(robot.locations) == 1), ros.outputs()


def test_odometry_that_stops_is_told_and_nothing_is_published(ros):
    robot = Robot(ros)
    robot.drive(0)
    robot.see(5)
    robot.node.wait_for('Lookup would require extrapolation into the future')
    assert robot.locations == []


def test_odometry_of_other_frames_is_told_with_both_names(ros):
    robot = Robot(ros)
    robot.drive(0, child='base_footprint')
    robot.node.wait_for(
        "it is of 'base_footprint' in 'odom': expected base_frame 'base_link' in fixed_frame 'odom'"
    )


def test_a_fixed_frame_that_localization_moves_is_warned_of(ros):
    ros.start('locator', fixed_frame='map', **RED).wait_for('fixed_frame map: localization moves')


def test_a_color_whose_height_nothing_tells_is_warned_of(ros):
    """Nothing says that objects are wrong by it: they seem to roll as the robot drives."""
    node = ros.start('locator', **(RED | {'red.diameter': '0.0'}))
    node.wait_for('red: neither NAME.diameter nor NAME.height is told: centers are taken to be on')


def test_pictures_of_another_clock_are_not_predicted_to_now(ros):
    """Those of a bag: 25 years later, objects would be anywhere."""
    robot = Robot(ros, predict_to_now='true')
    robot.drive(0)
    robot.see(0)
    assert ros.spin(lambda: len(robot.locations) == 1), ros.outputs()
    assert robot.locations[0].header.stamp.sec == START // 10**9
    (row,) = locations_of_cloud(robot.locations[0]).rows
    assert (row['x'], row['y'], row['z']) == pytest.approx(BALL, abs=0.01)
    robot.node.wait_for('predict_to_now: the picture is ')


def test_an_uncalibrated_camera_is_told_and_nothing_is_published(ros):
    robot = Robot(ros)
    robot.drive(0)
    robot.see(0, (0.0,) * 9)
    robot.node.wait_for('has not been calibrated')
    ros.spin(lambda: False, 1.0)
    assert robot.locations == []


def test_vision_msgs_carry_ids_classes_boxes_and_covariances(ros):
    vision = pytest.importorskip(
        'vision_msgs.msg', reason='vision_msgs is in no wheel; a robot has it'
    )
    robot = Robot(ros)
    flat = ros.listen(vision.Detection2DArray, 'locations/detections_2d')
    solid = ros.listen(vision.Detection3DArray, 'locations/detections_3d')
    assert ros.spin(lambda: ros.node.count_publishers('locations/detections_3d') == 1)
    ros.settle()
    robot.drive(0)
    robot.see(0)
    assert ros.spin(lambda: flat and solid and robot.locations), ros.outputs()
    (box,), (ball,) = flat[0].detections, solid[0].detections
    assert box.id == ball.id == '7'
    assert [one.results[0].hypothesis.class_id for one in (box, ball)] == ['red', 'red']
    assert 100 < box.bbox.center.position.x < 540
    assert box.bbox.size_x == pytest.approx(36, abs=3)
    assert flat[0].header.frame_id == 'cam'
    assert solid[0].header == robot.locations[0].header
    where, (row,) = ball.results[0].pose, locations_of_cloud(robot.locations[0]).rows
    assert where.pose.position.x == pytest.approx(row['x'])
    covariance = np.reshape(where.covariance, (6, 6))[:3, :3]
    assert covariance == pytest.approx(row['covariance'][:3, :3])
    assert ball.bbox.size.z == pytest.approx(0.2)
