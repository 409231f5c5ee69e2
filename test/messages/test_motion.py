import math

from geometry_msgs.msg import Twist
from geometry_msgs.msg import TwistStamped
import pytest
from rclpy.serialization import serialize_message

from colortrack_ros.messages import MessageError
from colortrack_ros.messages import odometry_on_ground
from colortrack_ros.messages import speeds_of_serialized_twist
from colortrack_ros.messages import twist_of


def test_odometry_tells_where_a_robot_is_and_how_it_moves_in_its_own_frame():
    message = odometry_on_ground((1, 2, math.pi / 2), (0.5, -0.3), 3 * 10**9 + 7, 'odom', 'base')
    assert (message.header.frame_id, message.child_frame_id) == ('odom', 'base')
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (3, 7)
    pose, twist = message.pose.pose, message.twist.twist
    assert (pose.position.x, pose.position.y, pose.position.z) == (1, 2, 0)
    turn = pose.orientation
    assert (turn.x, turn.y) == (0, 0)
    assert (turn.z, turn.w) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))
    assert (twist.linear.x, twist.angular.z) == (0.5, -0.3)


@pytest.mark.parametrize('stamped', [False, True])
def test_speeds_come_back_from_their_command(stamped):
    twist = twist_of(0.4, -1.2)
    message = TwistStamped(twist=twist) if stamped else twist
    cdr = serialize_message(message)
    assert speeds_of_serialized_twist(cdr, stamped=stamped) == (0.4, -1.2)


@pytest.mark.parametrize('speeds', [(math.nan, 0.0), (0.0, math.inf)])
def test_a_command_of_no_number_is_refused(speeds):
    with pytest.raises(MessageError, match='expected finite numbers'):
        speeds_of_serialized_twist(serialize_message(twist_of(*speeds)), stamped=False)


def test_another_kind_of_command_is_refused():
    with pytest.raises(MessageError):
        speeds_of_serialized_twist(serialize_message(Twist())[:20], stamped=False)
