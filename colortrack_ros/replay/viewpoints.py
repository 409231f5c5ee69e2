"""The pose of the camera for each picture of a bag, from odometry."""

from collections.abc import Callable
import dataclasses
from pathlib import Path
from typing import Any

from sensor_msgs.msg import CameraInfo

from colortrack_ros.bags import BagError
from colortrack_ros.bags import BagReader
from colortrack_ros.bags import Topic
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.flow.stage import Stage
from colortrack_ros.messages import MessageError
from colortrack_ros.messages.serialized import message_of_serialized
from colortrack_ros.node_kit.camera_pose import CameraPoseConfig
from colortrack_ros.node_kit.odometry import OdometryBuffer
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.world import CalibrationError
from colortrack_ros.world import CameraModel
from colortrack_ros.world import Pose
from colortrack_ros.world import TransformError
from colortrack_ros.world.poses import NO_ROBOT
from colortrack_ros.world.view import JumpWatch
from colortrack_ros.world.view import View
from colortrack_ros.world.waiting import LONGEST_WAIT

CAMERA_INFO, ODOMETRY = 'sensor_msgs/msg/CameraInfo', 'nav_msgs/msg/Odometry'


class RecordedViewpoints:
    """Reads odometry along with the pictures, as far ahead as a node would wait for it.

    :param path: of the bag.
    :param config: of the tracker.
    :param info_topic, odometry_topic: full names.
    :raises BagError: it cannot be opened.
    :raises StartError: it lacks the topics that give the pose of the camera.
    """

    def __init__(
        self, path: Path, config: CameraPoseConfig, info_topic: str, odometry_topic: str
    ) -> None:
        if config.pose_source == 'tf':
            raise StartError(
                'pose_source: expected odometry or fixed, got tf, which replay does not read'
            )
        self._reader = BagReader(path)
        place = config.camera_pose
        self._mount = Pose.of_rpy(place[:3], place[3:])
        self._reason, self._rectified = '', config.rectified
        self._buffer = OdometryBuffer(config, self._refuse)
        self._moves = config.pose_source == 'odometry'
        try:
            self._camera = self._lens(self._topic(info_topic, CAMERA_INFO))
            if self._moves:
                self._messages = self._reader.messages(self._topic(odometry_topic, ODOMETRY))
        except (StartError, MessageError, CalibrationError) as error:
            self._reader.close()
            raise StartError(f'{path}: ego_motion: odometry: {error}') from error
        self._next: tuple[int, bytes] | None = (0, b'')
        if self._moves:
            self._read_on()

    def _topic(self, name: str, kind: str) -> Topic:
        for topic in self._reader.topics:
            if topic[:2] == (name, kind):
                return topic
        there = ', '.join(topic.name for topic in self._reader.topics if topic.kind == kind)
        raise StartError(f'no topic {name} of {kind} there; there are: {there or "none"}')

    def _lens(self, topic: Topic) -> CameraModel:
        _, cdr = next(self._reader.messages(topic))
        return CameraModel.of_info(message_of_serialized(cdr, CameraInfo), self._rectified)

    def _refuse(self, reason: str) -> None:
        self._reason = reason

    def _read_on(self) -> None:
        """Read the next message of odometry; a truncated bag simply ends."""
        try:
            self._next = next(self._messages, None)
        except BagError:
            self._next = None

    def at(self, stamp: int, log_time: int) -> View:
        """The camera at a picture.

        :param stamp: of the picture, log_time: when it was recorded [ns].
        :raises TransformError: it is unknown; with the last reason why odometry was refused.
        """
        if not self._moves:
            return View(self._camera, NO_ROBOT, self._mount)
        poses, latest = self._buffer.poses, log_time + round(LONGEST_WAIT * NANOSECONDS)
        while self._next is not None:
            told, cdr = self._next
            if told > (log_time if len(poses) and poses.latest()[0] >= stamp else latest):
                break
            self._buffer.take(cdr)
            self._read_on()
        try:
            return View(self._camera, poses.at(stamp), self._mount)
        except TransformError as error:
            why = f'{error}; {self._reason}' if self._reason else str(error)
            raise TransformError(why, later=error.later) from error

    def close(self) -> None:
        """Close the files."""
        self._reader.close()


class WithViewpoints:
    """Passes on detections with the viewpoint of their picture, if it is known.

    :param stage: takes them; the context of each is its item.
    :param warn: takes the reason why a viewpoint is unknown.
    """

    def __init__(
        self,
        stage: Stage[Detections, Tracks],
        viewpoints: RecordedViewpoints,
        warn: Callable[[str], object],
    ) -> None:
        self._stage, self._viewpoints, self._warn = stage, viewpoints, warn
        self._watch = JumpWatch()

    def put(self, item: Detections, context: Any = None) -> None:
        """Take the next detections."""
        try:
            view = self._viewpoints.at(item.stamp, context.log_time)
            view = self._watch.checked(item.stamp, view)
        except TransformError as error:
            self._warn(f'the viewpoint; tracks continue as if the camera stood still: {error}')
        else:
            item = dataclasses.replace(item, viewpoint=view)
        self._stage.put(item, context)

    def flush(self) -> None:
        """Process everything that is waiting; the input has ended."""
        self._stage.flush()
