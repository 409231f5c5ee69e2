"""The camera at a given time: its lens and its pose."""

from collections.abc import Callable

from rclpy.node import Node
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.messages import MessageError
from colortrack_ros.messages.header import stamp_of
from colortrack_ros.messages.serialized import message_of_serialized
from colortrack_ros.node_kit.camera_pose import CameraPoseConfig
from colortrack_ros.node_kit.camera_pose import CameraPoses
from colortrack_ros.node_kit.camera_pose import OdometryPoses
from colortrack_ros.node_kit.camera_pose import TfPoses
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.world import CalibrationError
from colortrack_ros.world import CameraModel
from colortrack_ros.world import TransformError
from colortrack_ros.world.view import View
from colortrack_ros.world.waiting import LONGEST_WAIT


class CameraViews:
    """The lens from CameraInfo, the pose from odometry or TF.

    A CameraInfo is of the picture with its stamp and of later ones: drivers that bin or crop change
    it while detectors are still busy with earlier pictures.

    :param config: source of the pose.
    :param info_topic: of the CameraInfo.
    :param refuse: takes the reason why a message is refused.
    :param came: called after each message that gives a pose.
    :raises StartError: the pose is to come from TF, and tf2_ros is not installed.
    """

    def __init__(
        self,
        node: Node,
        config: CameraPoseConfig,
        info_topic: str,
        refuse: Callable[[str], object],
        came: Callable[[], object],
    ) -> None:
        self._refuse, self._info_topic, self._node = refuse, info_topic, node
        self._rectified = config.rectified
        self._camera: CameraModel | None = None
        self._before: CameraModel | None = None
        self._since, self._frame_id = 0, ''
        self._info = CameraInfo()
        self._frames = ('', '')
        self._poses: CameraPoses
        if config.pose_source == 'tf':
            self._poses = TfPoses(node, config, refuse)
        elif config.pose_source == 'fixed':
            self._poses = CameraPoses(config)
        else:
            self._poses = OdometryPoses(node, config, refuse, came)
        subscribe_to(node, CameraInfo, info_topic, self._learn_lens, refuse)

    def configure(self, config: CameraPoseConfig) -> None:
        """Apply another camera_pose."""
        self._poses.config = config

    def _learn_lens(self, cdr: bytes) -> None:
        """Take a serialized CameraInfo."""
        try:
            info = message_of_serialized(cdr, CameraInfo)
            frame_id, stamp = info.header.frame_id, stamp_of(info.header)
            info.header = Header()  # all else is mostly the same
            if stamp < self._since:
                self._before = None  # time has gone back
            if self._camera is None or info != self._info:
                self._before, self._since = self._camera, stamp
                self._camera, self._info = CameraModel.of_info(info, self._rectified), info
            self._frame_id = frame_id
        except (MessageError, CalibrationError) as error:
            self._camera = self._before = None
            self._refuse(str(error))

    def at(self, stamp: int, frame_id: str) -> View:
        """The camera at a time [ns].

        :param frame_id: of the picture.
        :raises TransformError: lens or pose is unknown.
        """
        if self._camera is None:
            raise TransformError(
                f'no calibration has come on {self._info_topic}: where a pixel looks to cannot be '
                'told without CameraInfo',
                later=True,
            )
        self._compare(frame_id)
        camera = self._camera
        if self._before is not None and 0 < self._since - stamp <= LONGEST_WAIT * NANOSECONDS:
            camera = self._before
        return View(camera, *self._poses.at(stamp, frame_id))

    def _compare(self, frame_id: str) -> None:
        """Warn once if the CameraInfo is of another frame than the picture: of another camera?"""
        frames = self._frame_id, frame_id
        if all(frames) and frames[0] != frames[1] and frames != self._frames:
            self._frames = frames
            self._node.get_logger().warning(
                f'CameraInfo on {self._info_topic} is of frame {frames[0]!r}, and pictures are of '
                f'{frames[1]!r}: if it is that of another camera, objects are elsewhere; expected '
                'one frame for both'
            )
