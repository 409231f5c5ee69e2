"""Pose of the camera: from odometry and its mount on the robot, or from TF."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
import math
from typing import Any

from rclpy.node import Node
from rclpy.time import Time

from colortrack_ros.data import Floats
from colortrack_ros.node_kit.odometry import OdometryConfig
from colortrack_ros.node_kit.odometry import receive_odometry
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.node_kit.transform_intake import TransformIntake
from colortrack_ros.parameters import parameter
from colortrack_ros.world.course import way_at
from colortrack_ros.world.poses import NO_ROBOT
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.poses import require_radians
from colortrack_ros.world.poses import TransformError

STEEPLY = math.cos(math.pi / 4)
"""Least cosine to straight up of the axis of a camera that is said to look up: the z of its body is
that steep, as long as it pitches by less than 45 degrees. Chosen."""


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

    def check(self) -> None:
        """Check the unit of the angles."""
        require_radians(self.camera_pose)


class CameraPoses:
    """Poses of a camera that camera_pose says: it is stationary in the fixed frame."""

    def __init__(self, config: CameraPoseConfig) -> None:
        self.config = config
        """A changed camera_pose applies from now on."""

    def at(self, stamp: int, frame_id: str) -> tuple[Pose, Pose, Floats | None]:
        """Return the poses of the robot in the fixed frame and of the camera body on the robot, and
        how the robot moves; see View.

        :param stamp: [ns].
        :param frame_id: of the picture.
        :raises TransformError: the pose is unknown.
        """
        place = self.config.camera_pose
        return NO_ROBOT, Pose.of_rpy(place[:3], place[3:]), None


class OdometryPoses(CameraPoses):
    """Poses from nav_msgs/Odometry and camera_pose; see receive_odometry() for the parameters."""

    def __init__(
        self,
        node: Node,
        config: CameraPoseConfig,
        refuse: Callable[[str], object],
        came: Callable[[], object],
    ) -> None:
        super().__init__(config)
        self._poses = receive_odometry(node, config, refuse, came)

    def at(self, stamp: int, frame_id: str) -> tuple[Pose, Pose, Floats | None]:
        """See CameraPoses."""
        base = self._poses.at(stamp)
        return base, super().at(stamp, frame_id)[1], way_at(self._poses.at, stamp, base)


class TfPoses(CameraPoses):
    """Poses from TF, also that of the camera on the robot.

    :param refuse: receives the reason if transforms start anew.
    :raises StartError: tf2_ros is not installed.
    """

    def __init__(
        self, node: Node, config: CameraPoseConfig, refuse: Callable[[str], object]
    ) -> None:
        try:
            import tf2_ros
        except ImportError as error:
            raise StartError(
                'pose_source tf needs tf2_ros, which cannot be imported: install '
                'ros-jazzy-tf2-ros-py, or set pose_source: odometry'
            ) from error
        super().__init__(config)
        self._tf2, self._logger, self._told_of = tf2_ros, node.get_logger(), ''
        self._buffer = tf2_ros.Buffer()
        self._intake = TransformIntake(self._buffer, refuse)
        self._listener = tf2_ros.TransformListener(self._intake, node)

    def at(self, stamp: int, frame_id: str) -> tuple[Pose, Pose, Floats | None]:
        """See CameraPoses."""
        config = self.config
        optical = config.camera_frame or frame_id
        of_robot, of_camera = 'fixed_frame from base_frame', 'base_frame from camera_frame'
        if not config.camera_frame:
            of_camera += ', which is empty, so from that of the pictures'
        robot = partial(self._lookup, of_robot, config.fixed_frame, config.base_frame)
        base = robot(stamp)
        mount = self._lookup(of_camera, config.base_frame, optical, stamp)
        if self._told_of != optical and (line := looks_up(optical, mount)):
            self._told_of = optical
            self._logger.warning(line)
        return base, mount @ OPTICAL.inverse(), way_at(robot, stamp, base)

    def _lookup(self, what: str, parent: str, child: str, stamp: int) -> Pose:
        if line := self._intake.rival(child, parent):
            raise TransformError(f'{what}: {line}')
        try:
            found: Any = self._buffer.lookup_transform(parent, child, Time(nanoseconds=stamp))
        except self._tf2.TransformException as error:
            # a future transform may still arrive, a past one will not
            past = 'extrapolation into the past' in str(error)
            reason = f'{what}: {" ".join(str(error).split())}'
            raise TransformError(reason, later=not past) from error
        t, q = found.transform.translation, found.transform.rotation
        return Pose.of_quaternion((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))


def looks_up(frame: str, mount: Pose) -> str:
    """Report a frame in which a camera would look up: it may be that of its body; empty if not.

    :param mount: of the frame, taken as optical, on the robot.
    """
    if mount.R[2, 2] < STEEPLY:
        return ''
    return (
        f'in TF, z of camera_frame {frame!r} points up: unless the camera does look up, this is '
        'the frame of its body; expected its optical frame: z forward, x right, y down, often '
        f'{frame.removesuffix("_link").removesuffix("_frame")}_optical_frame'
    )
