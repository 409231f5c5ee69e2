"""The locator with the poses of TF, where tf2_ros is."""

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
import numpy as np
import pytest
from support.ball_before_camera import BALL
from support.ball_before_camera import PLACE
from support.ball_before_camera import START
from support.ball_before_camera import view_of
from support.locating_robot import FRAME
from support.locating_robot import RED
from support.locating_robot import Robot

from colortrack_ros.messages import header_of
from colortrack_ros.messages import locations_of_cloud
from colortrack_ros.world import Pose
from colortrack_ros.world.poses import OPTICAL


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


def test_two_nodes_that_publish_one_frame_in_tf_are_told(ros):
    """A driver, and a filter that has drifted: nothing is located in between."""
    tf2_ros = pytest.importorskip('tf2_ros', reason='tf2_ros is in no wheel; a robot has it')
    robot = Robot(ros, pose_source='tf')
    moving = tf2_ros.TransformBroadcaster(ros.node)
    fixed = tf2_ros.StaticTransformBroadcaster(ros.node)
    camera = Pose.of_rpy(PLACE[:3], PLACE[3:]) @ OPTICAL
    fixed.sendTransform(transform('base_footprint', 'base_link', 0, Pose(np.zeros(3), np.eye(3))))
    fixed.sendTransform(transform('base_link', 'cam', 0, camera))
    ros.settle()
    for k in range(20):
        for off, late in ((0.0, 0), (0.4, FRAME // 2)):
            base = Pose.of_rpy((0.02 * k + off, 0, 0), (0, 0, 0))
            moving.sendTransform(
                transform('odom', 'base_footprint', START + k * FRAME + late, base)
            )
    robot.see(19)
    robot.node.wait_for("'base_footprint' goes to and fro by 0.38 m")
    robot.node.wait_for('several nodes publish it in TF, or its poses are that noisy')
    assert robot.locations == []


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


def test_a_frame_of_pictures_that_is_the_body_of_the_camera_is_told(ros):
    """Drivers that stamp pictures with camera_link: by it, the camera looks up to the ceiling."""
    tf2_ros = pytest.importorskip('tf2_ros', reason='tf2_ros is in no wheel; a robot has it')
    robot = Robot(ros, pose_source='tf', method='size')
    moving = tf2_ros.TransformBroadcaster(ros.node)
    fixed = tf2_ros.StaticTransformBroadcaster(ros.node)
    fixed.sendTransform(transform('base_link', 'cam', 0, Pose.of_rpy(PLACE[:3], PLACE[3:])))
    ros.settle()
    base = Pose.of_rpy((0, 0, 0), (0, 0, 0))
    moving.sendTransform([transform('odom', 'base_link', START + k * FRAME, base) for k in (0, 1)])
    robot.see(0)
    robot.node.wait_for("in TF, z of camera_frame 'cam' points up: unless the camera does look up")


def test_a_frame_of_pictures_that_tf_does_not_know_is_told(ros):
    tf2_ros = pytest.importorskip('tf2_ros', reason='tf2_ros is in no wheel; a robot has it')
    robot = Robot(ros, pose_source='tf')
    moving = tf2_ros.TransformBroadcaster(ros.node)
    base = Pose.of_rpy((0, 0, 0), (0, 0, 0))
    moving.sendTransform([transform('odom', 'base_link', START + k * FRAME, base) for k in (0, 1)])
    robot.see(0)
    robot.node.wait_for('camera_frame, which is empty, so from that of the pictures: "cam" passed')
