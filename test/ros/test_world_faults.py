"""What is wrong with calibration, frames, odometry or time is told in one line by real nodes."""

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from support.ball_before_camera import BALL
from support.ball_before_camera import info
from support.ball_before_camera import odometry
from support.ball_before_camera import picture
from support.ball_before_camera import PLACE
from support.ball_before_camera import START
from support.locating_robot import FRAME
from support.locating_robot import Robot

from colortrack_ros.messages import locations_of_cloud


def drive(robot, frames, answered=True, twist=0.0, **changed):
    """Let the robot see the ball for some frames: an odometry message and a picture each.

    :param twist: forward speed by the odometry [m/s].
    :param changed: x of odometry and of the picture, stamp, camera matrix, by functions of k.
    """
    told = {'x': lambda k: 0.02 * k, 'stamp': lambda k: START + k * FRAME, 'k': lambda _: None}
    told.update(changed)
    for k in frames:
        stamp, matrix = told['stamp'](k), told['k'](k)
        message = odometry(stamp, told['x'](k))
        message.twist.twist.linear.x = twist
        robot.odometry.publish(message)
        robot.info.publish(info(stamp, matrix) if matrix else info(stamp))
        seen, tracked = picture(stamp, 0.02 * k)
        count = len(robot.locations)
        robot.detections.publish(seen)
        robot.tracks.publish(tracked)
        if answered:
            assert robot.ros.spin(lambda c=count: len(robot.locations) > c), robot.ros.outputs()


def last(robot):
    return locations_of_cloud(robot.locations[-1]).rows


def test_odometry_that_jumps_is_told_and_objects_are_where_they_are_in_it(ros):
    robot = Robot(ros, patient=True)
    drive(robot, range(10))
    drive(robot, range(10, 20), x=lambda k: 0.02 * k + 1.5)
    robot.node.wait_for('the robot has jumped by 1.52 m and 0 degrees in 0.040 s')
    (row,) = last(robot)
    assert (row['x'], row['y']) == pytest.approx((BALL[0] + 1.5, BALL[1]), abs=0.02)


def test_a_driver_that_repeats_its_last_message_with_new_stamps_is_told(ros):
    """Its twist still drives while its pose stands."""
    robot = Robot(ros, patient=True)
    drive(robot, range(10), twist=0.5)
    drive(robot, range(10, 45), x=lambda k: 0.02 * 9, twist=0.5)
    robot.node.wait_for('odometry contradicts itself: its pose stands while its twist drives')


def test_odometry_that_stops_is_told_and_nothing_is_published_from_then_on(ros):
    robot = Robot(ros)
    drive(robot, range(10))
    for k in range(10, 15):
        robot.see(k)
    robot.node.wait_for('Lookup would require extrapolation into the future')
    assert len(robot.locations) == 10


@pytest.mark.parametrize('back', [10**12, 10**9])
def test_a_clock_that_goes_back_is_told_and_objects_are_located_again(ros, back):
    robot = Robot(ros)
    drive(robot, range(10))
    drive(robot, range(1), stamp=lambda k: START - back, answered=False)
    robot.node.wait_for('its time has gone back by more than 0.5 s: poses start anew')
    count = len(robot.locations)
    drive(robot, range(1, 10), stamp=lambda k: START - back + k * FRAME, answered=False)
    assert ros.spin(lambda: len(robot.locations) >= count + 8), ros.outputs()
    (row,) = last(robot)
    assert (row['x'], row['y']) == pytest.approx(BALL[:2], abs=0.02)


def test_a_camera_that_is_calibrated_anew_locates_at_once(ros):
    """As by camera_calibration, which tells a running camera."""
    robot = Robot(ros, patient=True)
    drive(robot, range(30), k=lambda _: (700.0, 0.0, 320.0, 0.0, 700.0, 240.0, 0.0, 0.0, 1.0))
    drive(robot, range(30, 40))
    robot.node.wait_for('the camera has been calibrated anew: objects restart')
    (row,) = last(robot)
    assert (row['x'], row['y']) == pytest.approx(BALL[:2], abs=0.02)


UPSIDE_DOWN = str([*map(float, PLACE[:3]), float(np.pi), 0.25, 0.0])


def test_a_camera_that_is_upside_down_is_told_and_nothing_is_published(ros):
    robot = Robot(ros, patient=True, camera_pose=UPSIDE_DOWN)
    drive(robot, range(10))
    robot.node.wait_for('where it is located: camera_pose (upside down?)')
    robot.node.wait_for('what is seen is not where it is located: nothing is published')
    assert [len(locations_of_cloud(cloud).rows) for cloud in robot.locations] == [0] * 10


def test_an_upside_down_camera_before_things_of_unknown_size_is_found_by_driving(ros):
    """By 0.5 m/s towards a ball; and told until camera_pose is mended, in diagnostics as well."""
    robot = Robot(
        ros, patient=True, camera_pose=UPSIDE_DOWN, **{'red.diameter': 0.0, 'red.height': 0.1}
    )
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    drive(robot, range(100))
    robot.node.wait_for('roll 0 for a camera that is upside down')
    assert len(last(robot)) == 0
    assert ros.spin(
        lambda: any('upside down' in s.message for array in diagnostics for s in array.status)
    )
    mended = Parameter('camera_pose', value=[float(number) for number in PLACE])
    request = SetParameters.Request(parameters=[mended.to_parameter_msg()])
    assert ros.call(SetParameters, '/locator/set_parameters', request).results[0].successful
    drive(robot, range(100, 110))
    assert last(robot)['x'] == pytest.approx(BALL[0], abs=0.1)


def test_the_calibration_of_another_size_is_told(ros):
    """Of a smaller picture: what is detected lies outside of it."""
    robot = Robot(ros)
    robot.info.publish(info(START))
    small = info(START)
    small.width, small.height = 160, 120
    small.k = [k / 4 if k != 1 else k for k in small.k]
    robot.odometry.publish(odometry(START, 0.0))
    seen, tracked = picture(START, 0.0)
    robot.info.publish(small)
    robot.ros.settle()
    robot.detections.publish(seen)
    robot.tracks.publish(tracked)
    robot.node.wait_for('is outside of the 160x120 picture of CameraInfo')


def test_the_focal_length_of_another_lens_is_told(ros):
    """By half: the ball is twice as large as it would be where its ray meets the ground."""
    robot = Robot(ros, patient=True)
    half = (260.0, 0.0, 320.0, 0.0, 260.0, 240.0, 0.0, 0.0, 1.0)
    drive(robot, range(10), k=lambda _: half)
    robot.node.wait_for('where it is located: camera_pose (upside down?), calibration')
