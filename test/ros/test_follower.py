from geometry_msgs.msg import PoseStamped
from geometry_msgs.msg import Twist
from geometry_msgs.msg import TwistStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from nav_msgs.msg import Odometry
import numpy as np
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import LOCATION
from colortrack_ros.data import Locations
from colortrack_ros.messages import cloud_of_locations
from colortrack_ros.messages import header_of
from colortrack_ros.messages import odometry_on_ground

PATIENT = 2.0
"""stop_within [s]: a busy machine may take that long from here to there."""


class Robot:
    """A robot that stands, with a follower that it listens to."""

    def __init__(self, ros, kind=Twist, code=None, arguments=(), **parameters):
        self.ros = ros
        given = {'stop_within': PATIENT} | parameters
        self.node = ros.start_code(code) if code else ros.start('follower', *arguments, **given)
        make = ros.node.create_publisher
        self.odometry, self.locations = (
            make(Odometry, 'odom', 10),
            make(PointCloud2, 'locations', 10),
        )
        self.poses = make(PoseStamped, 'target_pose', 10)
        self.clock, self.place = None, 0.0
        self.commands = ros.listen(kind, 'cmd_vel')
        assert ros.spin(lambda: self.odometry.get_subscription_count() == 1), ros.outputs()
        assert ros.spin(lambda: ros.node.count_publishers('cmd_vel') == 1)
        ros.settle()

    @property
    def now(self):
        return self.ros.node.get_clock().now().nanoseconds

    def tell(self, x=3.0, frame='odom', age=0.0, unseen=0.0, variance=1e-4):
        """Odometry of now, and an object x m ahead."""
        stamp = self.now
        if self.clock:
            self.clock.publish(Clock(clock=header_of(stamp, '').stamp))
        place = self.place, 0, 0
        self.odometry.publish(odometry_on_ground(place, (0, 0), stamp, 'odom', 'base_link'))
        rows = np.zeros(1, LOCATION)
        rows['x'], rows['track_id'], rows['state'] = x, 1, CONFIRMED
        rows['time_since_update'] = unseen
        rows['covariance'] = variance * np.eye(6)
        stamp -= round(age * 1e9)
        self.locations.publish(cloud_of_locations(Locations(rows, stamp, frame)))
        pose = PoseStamped(header=header_of(stamp, frame))
        pose.pose.position.x = x
        self.poses.publish(pose)

    def drives(self, wanted, tell=True, **what):
        """Whether it comes to drive, or to stand, while it is told all the time."""

        def done():
            if tell:
                self.tell(**what)
            fresh = self.last = self.commands[-1:]
            self.commands.clear()
            return bool(fresh) and (speed_of(fresh[0]) > 0.1) == wanted

        return self.ros.spin(done)

    def is_told(self, text, **what):
        """Whether the follower comes to say it, while it is told all the time."""
        return self.ros.spin(lambda: self.tell(**what) or text in self.node.output)


def speed_of(command):
    return getattr(command, 'twist', command).linear.x


def test_it_drives_after_an_object_until_it_is_stopped_or_hears_no_more(ros):
    robot = Robot(ros)
    assert robot.drives(True), ros.outputs()
    assert ros.call(Trigger, 'follower/stop', Trigger.Request()).success
    assert robot.drives(False)
    assert ros.call(Trigger, 'follower/start', Trigger.Request()).success
    assert robot.drives(True)
    assert robot.drives(False, tell=False)
    robot.node.wait_for('was last measured')
    assert robot.drives(True)
    robot.commands.clear()
    assert robot.node.stop() == 0
    assert ros.spin(lambda: robot.commands and speed_of(robot.commands[-1]) == 0.0)


def test_one_that_has_rested_starts_slowly(ros):
    """It went on at the speed of before at once."""
    robot = Robot(ros)

    def switch(number):
        request = ChangeState.Request(transition=Transition(id=number))
        assert ros.call(ChangeState, 'follower/change_state', request).success
        robot.commands.clear()

    def drives(least):
        robot.tell()
        return any(speed_of(command) > least for command in robot.commands)

    assert ros.spin(lambda: drives(0.45)), ros.outputs()
    switch(Transition.TRANSITION_DEACTIVATE)
    switch(Transition.TRANSITION_ACTIVATE)
    assert ros.spin(lambda: drives(0.0)), ros.outputs()
    assert next(speed for c in robot.commands if (speed := speed_of(c)) > 0) < 0.3


def test_odometry_that_ends_is_told_as_that_and_not_as_stamps_that_stand_still(ros):
    """Many commands follow from the last message of odometry."""
    robot = Robot(ros)
    assert robot.drives(True), ros.outputs()
    assert robot.drives(False, tell=False)
    robot.node.wait_for('was last measured')
    assert 'the stamps stand still' not in robot.node.output


def test_a_robot_without_odometry_is_told_why_it_stands(ros):
    """As with another odometry_topic, or a locator by TF: diagnostics said that all was well."""
    robot = Robot(ros)
    robot.odometry = ros.node.create_publisher(Odometry, 'wheels', 10)
    assert robot.is_told("no odometry of 'base_link' in 'odom' has come on /odom: the robot stands")
    assert robot.commands == []


def test_a_pose_is_followed_as_well_and_speeds_can_have_a_header(ros):
    robot = Robot(ros, TwistStamped, stamped='true', target_source='pose')
    assert robot.drives(True), ros.outputs()
    assert robot.last[0].header.frame_id == 'base_link'


def test_a_driver_that_takes_speeds_with_a_header_and_gets_none_is_told(ros):
    """As those of ros2_control do, unless told otherwise; rclpy itself says nothing."""
    robot = Robot(ros, TwistStamped)
    robot.node.wait_for(
        'test gets nothing from follower on /cmd_vel: it takes geometry_msgs/msg/TwistStamped, not '
        'geometry_msgs/msg/Twist'
    )


def test_objects_of_another_frame_or_another_time_are_told_and_not_followed(ros):
    robot = Robot(ros)

    def told(text):
        robot.tell(frame='map', age=0.0) if 'frame' in text else robot.tell(age=60.0)
        return text in robot.node.output

    for text in ("locations: they are in 'map': expected fixed_frame 'odom'", 'they are 60.'):
        assert ros.spin(lambda text=text: told(text)), ros.outputs()
    assert robot.commands == []


FAILS_LATER = """
import sys
from colortrack_ros.nodes import follower

step, fast = follower.Following.step, []

def fail_at_speed(*given):
    speeds = step(*given)
    fast.extend(speed for speed in speeds if speed > 0.15)
    return speeds if len(fast) < 10 else 1 // 0

follower.Following.step = fail_at_speed
sys.exit(follower.main())
"""


def test_a_robot_whose_follower_fails_stands(ros):
    robot = Robot(ros, code=FAILS_LATER)
    assert robot.drives(True), ros.outputs()

    def has_failed():
        robot.tell()
        return 'please report it: ZeroDivisionError' in robot.node.output

    assert ros.spin(has_failed), ros.outputs()
    assert robot.drives(False), ros.outputs()
    assert ros.call(Trigger, 'follower/stop', Trigger.Request()).success
    assert robot.node.stop() == 0


def test_a_target_that_comes_and_goes_is_told_once_a_second_at_most(ros):
    robot = Robot(ros, stop_within=0.3)
    assert robot.drives(True), ros.outputs()
    start = robot.now
    for _ in range(8):
        assert robot.drives(False, tell=False)
        assert robot.drives(True)
    robot.node.wait_for('was last measured')
    lines = sum(robot.node.output.count(text) for text in ('was last measured', ']: following'))
    assert lines <= 3 + 2 * (robot.now - start) * 1e-9
    assert ros.spin(lambda: robot.drives(True) and robot.node.output.endswith('following\n'))


def test_a_second_locator_or_robot_on_the_same_topics_stops_the_robot_and_is_told(ros):
    robot = Robot(ros)
    assert robot.drives(True), ros.outputs()
    for kind, topic in ((PointCloud2, 'locations'), (Odometry, 'odom')):
        other = ros.node.create_publisher(kind, topic, 10)
        assert ros.spin(lambda topic=topic: ros.node.count_publishers(topic) == 2)
        assert robot.drives(False), ros.outputs()
        assert robot.is_told(f'several nodes publish /{topic}'), ros.outputs()
        ros.node.destroy_publisher(other)
        assert robot.drives(True), ros.outputs()


def test_publishers_are_counted_on_the_topics_that_names_are_remapped_to(ros):
    """Not on those of the parameters, which may be anybody's."""
    remapped = ('-r', 'wheels:=odom', '-r', 'objects:=/locations')
    robot = Robot(ros, arguments=remapped, odometry_topic='wheels', locations_topic='objects')
    strangers = [ros.node.create_publisher(Odometry, 'wheels', 10) for _ in range(2)]
    assert ros.spin(lambda: ros.node.count_publishers('wheels') == 2)
    assert robot.drives(True), ros.outputs()
    other = ros.node.create_publisher(Odometry, 'odom', 10)
    assert robot.drives(False), ros.outputs()
    assert robot.is_told('several nodes publish /odom'), ros.outputs()
    for publisher in (other, *strangers):
        ros.node.destroy_publisher(publisher)


def test_odometry_that_is_reset_is_told(ros):
    robot = Robot(ros)
    assert robot.drives(True), ros.outputs()
    robot.place = 5.0
    assert robot.is_told('the robot has jumped by 5'), ros.outputs()
    assert robot.drives(True, x=8.0), ros.outputs()


def test_a_time_that_is_no_number_is_refused_and_the_robot_stands(ros):
    robot = Robot(ros, stop_within=0.3)
    assert robot.drives(True), ros.outputs()
    assert robot.drives(False, unseen=np.nan), ros.outputs()
    assert robot.is_told('got time_since_update nan', unseen=np.nan), ros.outputs()
    assert robot.node.stop() == 0


def test_a_covariance_that_is_none_is_refused_and_the_robot_stands(ros):
    """It stood, with a warning of NumPy about a square root, and nobody was told why."""
    robot = Robot(ros, stop_within=0.3)
    assert robot.drives(True), ros.outputs()
    assert robot.drives(False, variance=-1.0), ros.outputs()
    told = 'locations: expected a covariance, got one of variance -1 m^2'
    assert robot.is_told(told, variance=-1.0), ros.outputs()
    sideways = np.array([1e-4, -2.0, 1.0, 1.0, 1.0, 1.0])
    assert robot.is_told('got one of variance -2 m^2', variance=sideways), ros.outputs()
    assert 'RuntimeWarning' not in robot.node.output
    assert robot.drives(True), ros.outputs()


def test_a_clock_that_is_paused_stops_the_robot(ros):
    """Nothing is ever late by it, and a robot that is not simulated would drive on."""
    robot = Robot(ros, use_sim_time='true', stop_within=0.5)
    robot.clock = ros.node.create_publisher(Clock, '/clock', 10)
    assert robot.drives(True), ros.outputs()
    robot.clock, stood = None, robot.now
    assert robot.drives(False, tell=False), ros.outputs()
    robot.node.wait_for('the clock stands')
    assert robot.now >= stood
