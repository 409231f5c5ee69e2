"""nav_msgs/Odometry, and geometry_msgs/Twist with and without a header."""

from collections.abc import Sequence
import math

from geometry_msgs.msg import Point
from geometry_msgs.msg import Quaternion
from geometry_msgs.msg import Twist
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry

from colortrack_ros.messages.errors import MessageError
from colortrack_ros.messages.header import header_of
from colortrack_ros.messages.serialized import message_of_serialized


def odometry_on_ground(
    place: Sequence[float], speeds: Sequence[float], stamp: int, frame_id: str, child_frame_id: str
) -> Odometry:
    """The odometry of a robot on the ground.

    :param place: x, y [m], yaw [rad] of the child frame.
    :param speeds: forward [m/s], to the left around z [rad/s].
    """
    x, y, yaw = (float(number) for number in place)
    message = Odometry(header=header_of(stamp, frame_id), child_frame_id=child_frame_id)
    message.pose.pose.position = Point(x=x, y=y)
    message.pose.pose.orientation = Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    message.twist.twist = twist_of(*speeds)
    return message


def twist_of(speed: float, turn: float) -> Twist:
    """The command of a differential drive: forward [m/s], to the left around z [rad/s]."""
    twist = Twist()
    twist.linear.x, twist.angular.z = float(speed), float(turn)
    return twist


def speeds_of_serialized_twist(cdr: bytes, *, stamped: bool) -> tuple[float, float]:
    """Forward [m/s] and around z [rad/s] of a serialized Twist or TwistStamped.

    :raises MessageError: these are not the bytes of such a message, or numbers are not finite.
    """
    message = message_of_serialized(cdr, TwistStamped if stamped else Twist)
    twist = message.twist if stamped else message
    speeds = twist.linear.x, twist.angular.z
    if not all(map(math.isfinite, speeds)):
        raise MessageError(
            f'cmd_vel of {speeds[0]} m/s, {speeds[1]} rad/s: expected finite numbers'
        )
    return speeds
