"""Collects, for each picture, what a camera and its tracker publish."""

from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import Detections
from colortrack_ros.data import Tracks
from colortrack_ros.flow.order import OrderConfig
from colortrack_ros.flow.stage import Stage
from colortrack_ros.messages import depth_of_serialized_image
from colortrack_ros.messages import MessageError
from colortrack_ros.messages import tracks_of_serialized_cloud
from colortrack_ros.node_kit.camera_pose import CameraPoseConfig
from colortrack_ros.node_kit.camera_view import CameraViews
from colortrack_ros.node_kit.clocks import lacks_clock
from colortrack_ros.node_kit.clocks import seconds_of
from colortrack_ros.node_kit.detections_intake import DetectionsConfig
from colortrack_ros.node_kit.detections_intake import subscribe_to_detections
from colortrack_ros.node_kit.topics import require_namespace
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import named
from colortrack_ros.parameters import parameter
from colortrack_ros.parameters import part
from colortrack_ros.world.poses import require_radians
from colortrack_ros.world.view import View
from colortrack_ros.world.waiting import Waiting

Depth = NDArray[np.float32]


@dataclass(frozen=True)
class MountConfig(Config):
    """The pose of one of several cameras, NAME.camera_pose."""

    camera_pose: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        'As camera_pose, for this camera.',
        limits=(-100.0, 100.0),
    )

    def check(self) -> None:
        """Check the unit of the angles."""
        require_radians(self.camera_pose)


@dataclass(frozen=True)
class Mount:
    """One of several cameras.

    :param name: its namespace.
    :param config: its pose.
    """

    name: str
    config: MountConfig


@dataclass(frozen=True)
class CameraFeedConfig(Config):
    """The topics of one camera, or of each of several."""

    cameras: tuple[Mount, ...] = named(
        (),
        'Namespaces of the cameras, if there are several: the topics of NAME are '
        'NAME/<tracks_topic> and so on.',
        MountConfig,
        Mount,
        read_only=True,
        valid=require_namespace,
    )
    pose: CameraPoseConfig = part(CameraPoseConfig)
    detections: DetectionsConfig = part(DetectionsConfig)
    tracks_topic: str = topic_name('tracks', 'the tracks')
    camera_info_topic: str = topic_name('camera/camera_info', 'the calibration of the camera')
    depth_topic: str = topic_name(
        'camera/depth/image_raw', 'depth pictures, aligned, for methods depth and fused'
    )
    order: OrderConfig = part(OrderConfig)

    def check(self) -> None:
        """Several cameras share neither a namespace nor one frame."""
        names = [mount.name for mount in self.cameras]
        if len(set(names)) < len(names):
            raise ValueError(f'cameras: expected each name once, got {names}')
        if self.cameras and self.pose.camera_frame:
            raise ValueError(
                'camera_frame: expected none with several cameras, whose pictures tell it, got '
                f'{self.pose.camera_frame!r}'
            )

    @property
    def each(self) -> tuple['CameraFeedConfig', ...]:
        """The configuration of each camera, with its own topics and pose."""
        return tuple(self._of(mount) for mount in self.cameras) or (self,)

    def _of(self, mount: Mount) -> 'CameraFeedConfig':
        return replace(
            self,
            cameras=(),
            pose=replace(self.pose, camera_pose=mount.config.camera_pose),
            detections=replace(
                self.detections, detections_topic=f'{mount.name}/{self.detections.detections_topic}'
            ),
            tracks_topic=f'{mount.name}/{self.tracks_topic}',
            camera_info_topic=f'{mount.name}/{self.camera_info_topic}',
            depth_topic=f'{mount.name}/{self.depth_topic}',
        )


class CameraFeed:
    """Passes on the tracks, detections, view and depths of each picture.

    :param needs_depth: whether pictures wait for depths.
    :param release: takes them.
    :param took_in: called for each message of tracks.
    :param refuse: takes the reason why a message is refused.
    """

    def __init__(
        self,
        node: Node,
        config: CameraFeedConfig,
        release: Callable[[Tracks, Detections, View, Depth | None], object],
        took_in: Callable[[], object],
        refuse: Callable[[str], object],
        *,
        needs_depth: bool,
    ) -> None:
        self._node, self._took_in = node, took_in
        self._frame_id, self.active = '', False
        self._waiting = Waiting(self._view, release, refuse, seconds_of(node))
        self._waiting.needs_depth = needs_depth
        self._stage: Stage[Tracks, Tracks] = Stage(lambda tracks: tracks, refuse, seconds_of(node))
        self._stage.then(lambda tracks, _: self._waiting.put_tracks(tracks))
        self._views = CameraViews(
            node, config.pose, config.camera_info_topic, refuse, self._waiting.look
        )
        self.configure(config)
        self._read = config.detections.reader(node.get_logger().warning)
        subscribe_to_detections(node, config.detections, self._take_detections, refuse)
        subscribe_to(node, PointCloud2, config.tracks_topic, self._take_tracks, refuse)
        if needs_depth:
            subscribe_to(node, Image, config.depth_topic, self._take_depth, refuse)

    def configure(self, config: CameraFeedConfig) -> None:
        """Apply another pose of the camera, and another order."""
        self._views.configure(config.pose)
        self._stage.configure(config.order)

    def look(self) -> None:
        """Pass on pictures that are complete by now, and drop those that have waited too long."""
        self._stage.look(lambda: lacks_clock(self._node))
        self._waiting.look()

    def _view(self, stamp: int) -> View:
        return self._views.at(stamp, self._frame_id)

    def _take_detections(self, cdr: bytes) -> None:
        self._waiting.put_detections(self._read(cdr))

    def _take_depth(self, cdr: bytes) -> None:
        try:
            self._waiting.put_depth(*depth_of_serialized_image(cdr))
        except MessageError as error:
            self._waiting.refuse_depth(str(error))
            raise

    def _take_tracks(self, cdr: bytes) -> None:
        if not self.active:
            return
        tracks = tracks_of_serialized_cloud(cdr)
        self._took_in()
        self._frame_id = tracks.frame_id
        self._stage.put(tracks)
