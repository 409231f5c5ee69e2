"""TF broadcasts of a node, if tf2_ros is installed."""

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node

from colortrack_ros.messages import header_of
from colortrack_ros.world.poses import Pose


class Transforms:
    """Broadcasts the poses of a robot and its camera; does nothing without tf2_ros.

    :param parent: the fixed frame.
    :param base: frame of the robot.
    :param optical: optical frame of the camera.
    :param camera: pose of the optical frame on the robot.
    """

    def __init__(self, node: Node, parent: str, base: str, optical: str, camera: Pose) -> None:
        self._parent, self._base = parent, base
        self._moving = None
        try:
            import tf2_ros
        except ImportError:
            return
        self._moving = tf2_ros.TransformBroadcaster(node)
        self._fixed = tf2_ros.StaticTransformBroadcaster(node)
        self._fixed.sendTransform(_transform(base, optical, 0, camera))

    def tell(self, pose: Pose, stamp: int) -> None:
        """Broadcast the pose of the robot.

        :param stamp: [ns].
        """
        if self._moving:
            self._moving.sendTransform(_transform(self._parent, self._base, stamp, pose))


def _transform(parent: str, child: str, stamp: int, pose: Pose) -> TransformStamped:
    message = TransformStamped(header=header_of(stamp, parent), child_frame_id=child)
    where, turn = message.transform.translation, message.transform.rotation
    where.x, where.y, where.z = pose.t.tolist()
    turn.x, turn.y, turn.z, turn.w = map(float, pose.quaternion)
    return message
