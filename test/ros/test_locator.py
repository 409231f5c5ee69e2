from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray
from geometry_msgs.msg import PoseStamped
from geometry_msgs.msg import PoseWithCovarianceStamped
from geometry_msgs.msg import TransformStamped
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
from support.ball_before_camera import view_of
from support.locating_robot import FRAME
from support.locating_robot import RED
from support.locating_robot import Robot
from visualization_msgs.msg import MarkerArray

from colortrack_ros.messages import header_of
from colortrack_ros.messages import locations_of_cloud
from colortrack_ros.world import Pose
from colortrack_ros.world.poses import OPTICAL


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


def test_an_uncalibrated_camera_is_told_and_nothing_is_published(ros):
    robot = Robot(ros)
    robot.drive(0)
    robot.see(0, (0.0,) * 9)
    robot.node.wait_for('has not been calibrated')
    ros.spin(lambda: False, 1.0)
    assert robot.locations == []


def test_without_tf2_ros_tf_as_the_source_says_what_to_install(ros):
    try:
        import tf2_ros  # noqa: F401
    except ImportError:
        pass
    else:
        pytest.skip('tf2_ros is here')
    node = ros.start('locator', pose_source='tf', **RED)
    node.wait_for('pose_source tf needs tf2_ros, which cannot be imported')
    assert node.end() == 1


def transform(parent, child, stamp, pose):
    message = TransformStamped(header=header_of(stamp, parent), child_frame_id=child)
    where, turn = message.transform.translation, message.transform.rotation
    where.x, where.y, where.z = pose.t
    turn.x, turn.y, turn.z, turn.w = pose.quaternion
    return message


def test_by_tf_the_same_ball_is_at_the_same_place_and_a_frame_of_its_own(ros):
    tf2_ros = pytest.importorskip('tf2_ros', reason='tf2_ros is in no wheel; a robot has it')
    robot, diagnostics = Robot(ros, pose_source='tf'), ros.listen(DiagnosticArray, '/diagnostics')
    moving = tf2_ros.TransformBroadcaster(ros.node)
    fixed = tf2_ros.StaticTransformBroadcaster(ros.node)
    fixed.sendTransform(
        transform('base_link', 'cam', 0, Pose.of_rpy(PLACE[:3], PLACE[3:]) @ OPTICAL)
    )
    buffer = tf2_ros.Buffer(node=ros.node)
    listener = tf2_ros.TransformListener(buffer, ros.node)
    ros.settle()
    for k in range(10):
        base = Pose.of_rpy((0.02 * k, 0, 0), (0, 0, 0))
        moving.sendTransform(transform('odom', 'base_link', START + k * FRAME, base))
        robot.see(k)
        assert ros.spin(lambda k=k: len(robot.locations) == k + 1), ros.outputs()
    (row,) = locations_of_cloud(robot.locations[-1]).rows
    assert (row['x'], row['y'], row['z']) == pytest.approx(BALL, abs=0.01)
    last = robot.locations[-1].header.stamp
    assert ros.spin(lambda: buffer.can_transform('odom', 'target', last))
    at = buffer.lookup_transform('odom', 'target', last).transform.translation
    assert np.hypot(at.x - row['x'], at.y - row['y']) < 1e-6
    assert ros.spin(lambda: len(diagnostics) > 0)
    said = [status.message for array in diagnostics for status in array.status]
    assert not any('others publish' in message for message in said)
    del listener


@pytest.mark.parametrize('last', [500, 50])
def test_transforms_of_a_bag_that_loops_are_those_of_its_new_time(ros, last):
    tf2_ros = pytest.importorskip('tf2_ros', reason='tf2_ros is in no wheel; a robot has it')
    robot = Robot(ros, pose_source='tf', target_frame="''")
    moving = tf2_ros.TransformBroadcaster(ros.node)
    camera = Pose.of_rpy(PLACE[:3], PLACE[3:]) @ OPTICAL
    tf2_ros.StaticTransformBroadcaster(ros.node).sendTransform(
        transform('base_link', 'cam', 0, camera)
    )
    ros.settle()
    for k in (last, last + 1, 0, 1, 2):
        count, base = len(robot.locations), Pose.of_rpy((0.02 * (k % last), 0, 0), (0, 0, 0))
        moving.sendTransform(transform('odom', 'base_link', START + k * FRAME, base))
        robot.see(k, view=view_of(base, camera @ OPTICAL.inverse()))
        assert ros.spin(lambda c=count: len(robot.locations) > c), ros.outputs()
    (row,) = locations_of_cloud(robot.locations[-1]).rows
    assert (row['x'], row['y'], row['z']) == pytest.approx(BALL, abs=0.01)
    robot.node.wait_for("TF: the time of 'base_link' has gone back by more than 0.5 s: poses start")


def pan_tilt(k):
    """Of a robot that stands: base_link, and the head on it."""
    return Pose.of_rpy((0, 0, 0), (0, 0, 0)), Pose.of_rpy(
        (0.1, 0, 0.6), (0, 0.2 + 0.1 * np.sin(k), 0.1 + 0.3 * np.sin(0.7 * k))
    )


def drone(k):
    """Climbs, rolls and pitches by 20 degrees; its camera looks down by 45 degrees less."""
    lean = 0.35 * np.sin(0.9 * k), 0.35 * np.sin(0.7 * k)
    base = Pose.of_rpy((0.3 + 0.05 * k, 0.2, 1.8 + 0.05 * k), (*lean, 0.1 * np.sin(k)))
    return base, Pose.of_rpy((0.1, 0, -0.05), (0, np.pi / 4, 0))


@pytest.mark.parametrize('robot_of', [pan_tilt, drone])
@pytest.mark.parametrize('method', ['ground', 'size'])
def test_tf_tells_how_a_head_turns_and_a_drone_leans(ros, robot_of, method):
    """The head is another frame, that of the camera hangs on it."""
    tf2_ros = pytest.importorskip('tf2_ros', reason='tf2_ros is in no wheel; a robot has it')
    robot = Robot(ros, pose_source='tf', method=method)
    moving = tf2_ros.TransformBroadcaster(ros.node)
    fixed = tf2_ros.StaticTransformBroadcaster(ros.node)
    fixed.sendTransform(transform('head', 'cam', 0, OPTICAL))
    ros.settle()
    for k in range(10):
        (base, head), stamp = robot_of(k), START + k * FRAME
        moving.sendTransform(
            [
                transform('odom', 'base_link', stamp, base),
                transform('base_link', 'head', stamp, head),
            ]
        )
        robot.see(k, view=view_of(base, head))
        assert ros.spin(lambda k=k: len(robot.locations) == k + 1), ros.outputs()
        (row,) = locations_of_cloud(robot.locations[-1]).rows
        assert (row['x'], row['y'], row['z']) == pytest.approx(BALL, abs=0.03)
        assert np.hypot(row['vx'], row['vy']) < 0.1


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


def test_wrong_frame_names_in_tf_are_told(ros):
    tf2_ros = pytest.importorskip('tf2_ros', reason='tf2_ros is in no wheel; a robot has it')
    robot = Robot(ros, pose_source='tf', base_frame='base')
    moving = tf2_ros.TransformBroadcaster(ros.node)
    ros.settle()
    for k in range(2):
        base = Pose.of_rpy((0, 0, 0), (0, 0, 0))
        moving.sendTransform(transform('odom', 'base_link', START + k * FRAME, base))
    robot.see(0)
    robot.node.wait_for(
        'fixed_frame from base_frame: "base" passed to lookupTransform argument source_frame does '
        'not exist'
    )
    assert robot.locations == []


def test_a_frame_of_pictures_that_tf_does_not_know_is_told(ros):
    tf2_ros = pytest.importorskip('tf2_ros', reason='tf2_ros is in no wheel; a robot has it')
    robot = Robot(ros, pose_source='tf')
    moving = tf2_ros.TransformBroadcaster(ros.node)
    base = Pose.of_rpy((0, 0, 0), (0, 0, 0))
    moving.sendTransform([transform('odom', 'base_link', START + k * FRAME, base) for k in (0, 1)])
    robot.see(0)
    robot.node.wait_for('camera_frame, which is empty, so from that of the pictures: "cam" passed')
