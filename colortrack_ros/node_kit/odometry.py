"""Pose of the robot, from nav_msgs/Odometry."""

from collections.abc import Callable
from dataclasses import dataclass

from nav_msgs.msg import Odometry
from rclpy.node import Node

from colortrack_ros.messages import MessageError
from colortrack_ros.messages.header import stamp_of
from colortrack_ros.messages.serialized import message_of_serialized
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import parameter
from colortrack_ros.world.alternation import Alternation
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.poses import PoseBuffer
from colortrack_ros.world.poses import TransformError
from colortrack_ros.world.poses import WENT_BACK
from colortrack_ros.world.twists import Twists


@dataclass(frozen=True)
class OdometryConfig(Config):
    """Topic and frames of the odometry."""

    odometry_topic: str = topic_name('odom', 'the odometry')
    fixed_frame: str = parameter('odom', 'The frame in which objects are located.', read_only=True)
    base_frame: str = parameter('base_link', 'The frame of the robot.', read_only=True)


class OdometryBuffer:
    """Keeps the odometry poses of the last seconds.

    :param refuse: receives the reason if a message is rejected.
    :ivar poses: of base_frame in fixed_frame.
    """

    def __init__(self, config: OdometryConfig, refuse: Callable[[str], object]) -> None:
        self.poses = PoseBuffer(config.fixed_frame, config.base_frame)
        self._refuse, self._twists, self._watch = refuse, Twists(), Alternation()

    def take(self, cdr: bytes) -> None:
        """Add a serialized nav_msgs/Odometry."""
        try:
            self._take(message_of_serialized(cdr, Odometry))
        except (MessageError, TransformError) as error:
            self._refuse(f'odometry: {error}')

    def _take(self, message: Odometry) -> None:
        given = message.header.frame_id, message.child_frame_id
        wanted = self.poses.parent, self.poses.child
        if given != wanted:
            raise MessageError(
                f'it is of {given[1]!r} in {given[0]!r}: expected base_frame {wanted[1]!r} in '
                f'fixed_frame {wanted[0]!r}'
            )
        stamp, pose = stamp_of(message.header), message.pose.pose
        t, q = pose.position, pose.orientation
        place = Pose.of_quaternion((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))
        if not self.poses.add(stamp, place):
            self.poses.clear()
            self.poses.add(stamp, place)
            self._watch = Alternation()
            self._refuse(
                f'odometry: its time has gone back by more than {WENT_BACK:g} s: poses start anew'
            )
        self._watch.see(stamp, (t.x, t.y, t.z), (q.x, q.y, q.z, q.w))
        if line := self._watch.line:
            self._refuse(f'odometry {line}: several nodes publish it, or its poses are that noisy')
        v, w = message.twist.twist.linear, message.twist.twist.angular
        if line := self._twists.see(stamp, place, (v.x, v.y), w.z):
            self._refuse(f'odometry contradicts itself: {line}')


def receive_odometry(
    node: Node,
    config: OdometryConfig,
    refuse: Callable[[str], object],
    came: Callable[[], object] = lambda: None,
) -> PoseBuffer:
    """Subscribe to odometry; return the buffer of poses of the last seconds, filled from now on.

    :param refuse: receives the reason if a message is rejected.
    :param came: called after each message.
    """
    buffer = OdometryBuffer(config, refuse)

    def receive(cdr: bytes) -> None:
        buffer.take(cdr)
        came()

    subscribe_to(node, Odometry, config.odometry_topic, receive, refuse)
    return buffer.poses
