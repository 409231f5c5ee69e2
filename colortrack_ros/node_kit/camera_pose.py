"""Pose of the camera: from odometry and its mount on the robot, or from TF."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from typing import Protocol

from rclpy.node import Node
from rclpy.time import Time

from colortrack_ros.node_kit.odometry import OdometryConfig
from colortrack_ros.node_kit.odometry import receive_odometry
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.parameters import parameter
from colortrack_ros.world.poses import NO_ROBOT
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.poses import TransformError


@dataclass(frozen=True)
class CameraPoseConfig(OdometryConfig):
    """Source and frames of the camera's pose, and the calibration that applies to its pictures."""

    pose_source: str = parameter(
        'odometry',
        'Where poses come from: odometry_topic and camera_pose; TF, which needs tf2_ros; or fixed, '
        'camera_pose is in fixed_frame, and nothing moves.',
        choices=('odometry', 'tf', 'fixed'),
        read_only=True,
    )
    camera_frame: str = parameter(
        '',
        "The optical frame of the camera in TF; empty: that of the pictures' headers.",
        read_only=True,
    )
    camera_pose: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        'Where the camera is in base_frame, x forward and z up: x, y, z in m, roll, pitch, yaw in '
        'rad. Positive pitch looks down.',
        limits=(-100.0, 100.0),
    )
    rectified: bool = parameter(
        False,
        'Whether pictures are rectified, as image_rect of image_proc: they have the P of '
        'CameraInfo, and no distortion.',
        read_only=True,
    )


class CameraPoses(Protocol):
    """The pose of the camera over time."""

    def configure(self, config: CameraPoseConfig) -> None:
        """Apply a changed camera_pose."""

    def at(self, stamp: int, frame_id: str) -> tuple[Pose, Pose]:
        """Return the poses of the robot in the fixed frame and of the camera body on the robot.

        :param stamp: [ns].
        :param frame_id: of the picture.
        :raises TransformError: the pose is unknown.
        """


class OdometryPoses:
    """Poses from nav_msgs/Odometry and camera_pose; see receive_odometry() for the parameters."""

    def __init__(
        self,
        node: Node,
        config: CameraPoseConfig,
        refuse: Callable[[str], object],
        came: Callable[[], object],
    ) -> None:
        self._config = config
        self._poses = receive_odometry(node, config, refuse, came)

    def configure(self, config: CameraPoseConfig) -> None:
        """Apply a changed camera_pose."""
        self._config = config

    def at(self, stamp: int, frame_id: str) -> tuple[Pose, Pose]:
        """See CameraPoses."""
        place = self._config.camera_pose
        return self._poses.at(stamp), Pose.of_rpy(place[:3], place[3:])


class FixedPoses:
    """Poses of a stationary camera."""

    def __init__(self, config: CameraPoseConfig) -> None:
        self._config = config

    def configure(self, config: CameraPoseConfig) -> None:
        """Apply a changed camera_pose."""
        self._config = config

    def at(self, stamp: int, frame_id: str) -> tuple[Pose, Pose]:
        """See CameraPoses."""
        place = self._config.camera_pose
        return NO_ROBOT, Pose.of_rpy(place[:3], place[3:])


class TfPoses:
    """Poses from TF.

    :raises StartError: tf2_ros is not installed.
    """

    def __init__(self, node: Node, config: CameraPoseConfig) -> None:
        try:
            import tf2_ros
        except ImportError as error:
            raise StartError(
                'pose_source tf needs tf2_ros, which cannot be imported: install '
                'ros-jazzy-tf2-ros-py, or set pose_source: odometry'
            ) from error
        self._config, self._tf2 = config, tf2_ros
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer, node)

    def configure(self, config: CameraPoseConfig) -> None:
        """See CameraPoses; TF provides the pose of the camera on the robot."""

    def at(self, stamp: int, frame_id: str) -> tuple[Pose, Pose]:
        """See CameraPoses."""
        config = self._config
        optical = config.camera_frame or frame_id
        base = self._lookup(config.fixed_frame, config.base_frame, stamp)
        return base, self._lookup(config.base_frame, optical, stamp) @ OPTICAL.inverse()

    def _lookup(self, parent: str, child: str, stamp: int) -> Pose:
        try:
            found: Any = self._buffer.lookup_transform(parent, child, Time(nanoseconds=stamp))
        except self._tf2.TransformException as error:
            # a future transform may still arrive, a past one will not
            past = 'extrapolation into the past' in str(error)
            raise TransformError(' '.join(str(error).split()), later=not past) from error
        t, q = found.transform.translation, found.transform.rotation
        return Pose.of_quaternion((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))
