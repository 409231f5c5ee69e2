from geometry_msgs.msg import Twist
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from nav_msgs.msg import Odometry
import numpy as np
import pytest
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import Locations
from colortrack_ros.messages import cloud_of_locations
from colortrack_ros.messages import frame_of_image
from colortrack_ros.messages import header_of
from colortrack_ros.messages import locations_of_cloud
from colortrack_ros.messages import stamp_of
from colortrack_ros.messages import twist_of
from colortrack_ros.world import CameraModel
from colortrack_ros.world import Pose

SMALL = {'picture_size': '[64, 48]', 'focal_length': 52.0}


class Steps:
    """A simulator whose pictures wait for the answers of this test."""

    def __init__(self, ros, **parameters):
        self.ros = ros
        self.node = ros.start(
            'simulator', real_time='false', publish_clock='true', **SMALL, **parameters
        )
        self.commands = ros.node.create_publisher(Twist, 'cmd_vel', 10)
        self.answers = ros.node.create_publisher(PointCloud2, 'locations', 10)
        self.odometry = ros.listen(Odometry, 'odom')
        self.pictures = ros.listen(Image, 'camera/image_raw')
        assert ros.spin(lambda: self.commands.get_subscription_count() == 1), ros.outputs()
        assert ros.spin(lambda: self.answers.get_subscription_count() == 1)
        assert ros.spin(lambda: len(self.pictures) > 0)

    def go(self, pictures, speed=None):
        """Let so many pictures be taken, driving all the time if there is a speed."""
        for _ in range(pictures):
            if speed is not None:
                self.commands.publish(twist_of(speed, 0.0))
            count = len(self.pictures)
            answer = Locations(stamp=stamp_of(self.pictures[-1].header))
            self.answers.publish(cloud_of_locations(answer))
            assert self.ros.spin(lambda count=count: len(self.pictures) > count)


def test_a_picture_comes_with_all_that_belongs_to_it_and_a_robot_without_commands_stops(ros):
    others = {
        'camera/camera_info': CameraInfo, 'camera/depth/image_raw': Image,
        'truth': PointCloud2, '/clock': Clock,
    }  # fmt: skip
    heard = {topic: ros.listen(kind, topic) for topic, kind in others.items()}
    steps = Steps(ros)
    steps.go(45, speed=0.5)
    driven = steps.odometry[-1]
    assert driven.twist.twist.linear.x == pytest.approx(0.5)
    times = np.array([stamp_of(m.header) for m in steps.odometry]) * 1e-9
    speeds = [m.twist.twist.linear.x for m in steps.odometry]
    way = (np.diff(times) * speeds[1:]).sum() + steps.odometry[0].pose.pose.position.x
    assert driven.pose.pose.position.x == pytest.approx(way, abs=1e-3)
    assert way > 0.5
    steps.go(40)
    assert steps.odometry[-1].twist.twist.linear.x == 0.0
    assert (driven.header.frame_id, driven.child_frame_id) == ('odom', 'base_link')

    last = stamp_of(steps.pictures[-1].header)
    stamps = {t: lambda t=t: [stamp_of(m.header) for m in heard[t]] for t in others}
    stamps['/clock'] = lambda: [c.clock.sec * 10**9 + c.clock.nanosec for c in heard['/clock']]
    assert ros.spin(lambda: all(last in of() for of in stamps.values()))
    assert (np.diff(stamps['/clock']()) > 0).all()
    assert frame_of_image(steps.pictures[-1]).image.shape == (48, 64, 3)
    camera = CameraModel.of_info(heard['camera/camera_info'][-1])
    assert (camera.width, camera.K[0, 0]) == (64, 52.0)
    truth = locations_of_cloud(heard['truth'][-1])
    assert truth.frame_id == 'odom'
    assert truth.rows['track_id'].tolist() == [1, 2, 3, 4]
    assert heard['camera/depth/image_raw'][-1].encoding == '32FC1'


def test_speeds_that_are_none_are_refused_with_the_reason(ros):
    steps = Steps(ros)
    steps.go(2, speed=float('nan'))
    steps.node.wait_for('cmd_vel of nan m/s, 0.0 rad/s: expected finite numbers')
    steps.go(2)
    assert steps.odometry[-1].twist.twist.linear.x == 0.0


def test_time_goes_by_for_a_simulator_that_itself_publishes_the_clock_that_all_go_by(ros):
    """As with use_sim_time for /** in the params file."""
    node = ros.start('simulator', use_sim_time='true', publish_clock='true', **SMALL)
    odometry = ros.listen(Odometry, 'odom')

    def has_passed(seconds):
        stamps = [stamp_of(m.header) for m in odometry]
        return len(stamps) > 1 and stamps[-1] - stamps[0] > seconds * 1e9

    assert ros.spin(lambda: has_passed(0.5), 30.0), ros.outputs()
    assert node.stop() == 0


def test_a_robot_does_not_drive_while_the_simulation_rests(ros):
    ros.start('simulator', **SMALL)
    odometry = ros.listen(Odometry, 'odom')
    commands = ros.node.create_publisher(Twist, 'cmd_vel', 10)

    timer = ros.node.create_timer(0.05, lambda: commands.publish(twist_of(1.0, 0.0)))

    def change(transition):
        request = ChangeState.Request(transition=Transition(id=transition))
        return ros.call(ChangeState, 'simulator/change_state', request).success

    drives = ros.spin(lambda: odometry and odometry[-1].twist.twist.linear.x == 1.0)
    assert drives, ros.outputs()
    assert change(Transition.TRANSITION_DEACTIVATE)
    timer.cancel()
    ros.spin(lambda: False, 1.0)
    last = odometry[-1].pose.pose.position.x
    odometry.clear()
    assert not ros.spin(lambda: bool(odometry), 1.0)
    assert change(Transition.TRANSITION_ACTIVATE)
    assert ros.spin(lambda: len(odometry) > 5), ros.outputs()
    assert odometry[0].pose.pose.position.x - last < 0.2
    age = ros.node.get_clock().now().nanoseconds - stamp_of(odometry[-1].header)
    assert age < 1e9


def test_a_clock_that_is_set_back_takes_the_stamps_with_it_and_leaves_the_robot(ros):
    """The stamps stood still until it was as late again."""
    node = ros.start('simulator', use_sim_time='true', **SMALL)
    odometry, clock = ros.listen(Odometry, 'odom'), ros.node.create_publisher(Clock, '/clock', 10)
    commands = ros.node.create_publisher(Twist, 'cmd_vel', 10)
    shown = 5000.0

    def is_between(low, high):
        nonlocal shown
        shown += 0.05
        clock.publish(Clock(clock=header_of(round(shown * 1e9), '').stamp))
        commands.publish(twist_of(0.1, 0.0))
        return odometry and low < stamp_of(odometry[-1].header) * 1e-9 < high

    assert ros.spin(lambda: is_between(5000.2, 9000.0), 30.0), ros.outputs()
    assert 'has jumped' not in node.output
    shown = 100.0
    assert ros.spin(lambda: is_between(100.2, 1000.0), 30.0), ros.outputs()
    node.wait_for('the clock has jumped by -')
    shown = 4000.0
    assert ros.spin(lambda: is_between(4000.2, 9000.0), 30.0), ros.outputs()
    xs = [m.pose.pose.position.x for m in odometry]
    assert max(np.diff(xs)) < 0.1


def test_tf_leads_from_odom_over_the_robot_to_its_camera_as_it_is_in_the_pictures(ros):
    tf2_ros = pytest.importorskip('tf2_ros', reason='tf2_ros is in no wheel; a robot has it')
    buffer = tf2_ros.Buffer(node=ros.node)
    listener = tf2_ros.TransformListener(buffer, ros.node)
    steps = Steps(ros, camera_pose='[0.1, 0.0, 0.5, 0.0, 0.25, 0.0]')
    steps.go(20, speed=0.5)
    last = steps.odometry[-1]
    assert ros.spin(lambda: buffer.can_transform('odom', 'camera_optical_frame', last.header.stamp))
    found = buffer.lookup_transform('odom', 'camera_optical_frame', last.header.stamp).transform
    t, q = found.translation, found.rotation
    pose = Pose.of_quaternion((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))
    assert last.pose.pose.position.x > 0.1
    assert pose.t == pytest.approx((last.pose.pose.position.x + 0.1, 0.0, 0.5), abs=1e-6)
    # it looks ahead, and down by 0.25 rad
    assert pose.R[:, 2] == pytest.approx((np.cos(0.25), 0.0, -np.sin(0.25)))
    assert pose.R[:, 0] == pytest.approx((0.0, -1.0, 0.0), abs=1e-9)
    del listener


def test_a_locator_by_tf_finds_what_the_simulator_has(ros):
    """The chain of a robot, with TF alone."""
    pytest.importorskip('tf2_ros', reason='tf2_ros is in no wheel; a robot has it')
    color = {'colors': '[standing]', 'standing.rgb': '[38.0, 84.0, 176.0]'}
    ros.start('detector', min_area=20, **color)
    ros.start('tracker', ego_motion='odometry', pose_source='tf')
    of = {'colors': '[standing]', 'standing.diameter': 0.24, 'standing.motion': 'still'}
    ros.start('locator', pose_source='tf', **of)
    found, truth = ros.listen(PointCloud2, 'locations'), ros.listen(PointCloud2, 'truth')
    ros.start('simulator', rate=10.0)

    def rows():
        return locations_of_cloud(found[-1]).rows if found else []

    assert ros.spin(lambda: truth and len(rows()) > 0, 30.0), ros.outputs()
    (row,) = rows()
    true = locations_of_cloud(truth[-1]).rows
    away = np.hypot(true['x'] - row['x'], true['y'] - row['y'])
    assert away.min() < 0.1


def test_without_tf_a_simulator_publishes_none(ros):
    Steps(ros, publish_tf='false').go(2)
    assert ros.node.count_publishers('/tf') == 0
