"""The node that turns tracks into objects in meters."""

from dataclasses import dataclass
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

from colortrack_ros.data import Detections
from colortrack_ros.data import Tracks
from colortrack_ros.flow.order import IDLE
from colortrack_ros.flow.order import OrderConfig
from colortrack_ros.flow.stage import Stage
from colortrack_ros.messages import depth_of_serialized_image
from colortrack_ros.messages import detections_of_serialized_cloud
from colortrack_ros.messages import MessageError
from colortrack_ros.messages import tracks_of_serialized_cloud
from colortrack_ros.node_kit.camera_pose import CameraPoseConfig
from colortrack_ros.node_kit.camera_view import CameraViews
from colortrack_ros.node_kit.clocks import lacks_clock
from colortrack_ros.node_kit.clocks import seconds_of
from colortrack_ros.node_kit.clocks import STEADY
from colortrack_ros.node_kit.diagnostics import Health
from colortrack_ros.node_kit.locations_output import LocationsOutput
from colortrack_ros.node_kit.locations_output import LocationsOutputConfig
from colortrack_ros.node_kit.managed import ManagedNode
from colortrack_ros.node_kit.node_setup import NodeSetup
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.topics import PictureQueueConfig
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import part
from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world.selection import rule_of
from colortrack_ros.world.selection import Selector
from colortrack_ros.world.view import View
from colortrack_ros.world.waiting import Waiting


@dataclass(frozen=True)
class LocatorSetup(NodeSetup):
    """The parameters of the locator node."""

    config: LocatorConfig = part(LocatorConfig)
    pose: CameraPoseConfig = part(CameraPoseConfig)
    output: LocationsOutputConfig = part(LocationsOutputConfig)
    detections_topic: str = topic_name('detections', 'the detections')
    tracks_topic: str = topic_name('tracks', 'the tracks')
    camera_info_topic: str = topic_name('camera/camera_info', 'the calibration of the camera')
    depth_topic: str = topic_name(
        'camera/depth/image_raw', 'depth pictures, aligned, for methods depth and fused'
    )
    order: OrderConfig = part(OrderConfig)
    pictures: PictureQueueConfig = part(PictureQueueConfig)

    def check(self) -> None:
        """The target is one that there can be."""
        rule_of(self.output.select, self.names)

    @property
    def names(self) -> list[str]:
        """Of the colors."""
        return [kind.name for kind in self.config.colors]


class LocatorNode(ManagedNode[LocatorSetup]):
    """Tracks, detections, calibration and poses in; for each picture the objects in meters out."""

    def __init__(self, **options: Any) -> None:
        super().__init__('locator', LocatorSetup, **options)

    def configure(self) -> None:
        """Make a locator, and what it publishes and takes."""
        setup = self.setup
        self.health = Health(self, objects=lambda: self._output.alive)
        self._locator = Locator(setup.config, self.health.refuse)
        self._selector = Selector(setup.output.select, setup.names)
        self._waiting = Waiting(self._view, self._locate, self.health.refuse, seconds_of(self))
        self._waiting.needs_depth = setup.config.method in ('depth', 'fused')
        self._stage: Stage[Tracks, Tracks] = Stage(
            lambda tracks: tracks, self.health.refuse, seconds_of(self)
        )
        self._stage.configure(setup.order)
        self._stage.then(lambda tracks, _: self._waiting.put_tracks(tracks))
        self._views = CameraViews(
            self, setup.pose, setup.camera_info_topic, self.health.refuse, self._waiting.look
        )
        self._frame_id = ''
        self._output = LocationsOutput(
            self, setup.output, setup.names, tf=setup.pose.pose_source == 'tf'
        )
        subscribe_to(self, PointCloud2, setup.detections_topic, self._take_detections)
        subscribe_to(self, PointCloud2, setup.tracks_topic, self._take_tracks)
        if self._waiting.needs_depth:
            subscribe_to(self, Image, setup.depth_topic, self._take_depth)
        self.create_subscription(String, '~/select', self._select, 10)
        self.create_timer(IDLE, self._look, clock=STEADY)

    def _take_detections(self, cdr: bytes) -> None:
        try:
            self._waiting.put_detections(detections_of_serialized_cloud(cdr))
        except MessageError as error:
            self.health.refuse(str(error))

    def _take_depth(self, cdr: bytes) -> None:
        try:
            self._waiting.put_depth(*depth_of_serialized_image(cdr))
        except MessageError as error:
            self.health.refuse(str(error))

    def _take_tracks(self, cdr: bytes) -> None:
        if not self.active:
            return
        try:
            tracks = tracks_of_serialized_cloud(cdr)
        except MessageError as error:
            self.health.refuse(str(error))
            return
        self.health.took_in()
        self._frame_id = tracks.frame_id
        self._stage.put(tracks)

    def _view(self, stamp: int) -> View:
        """The camera at a time [ns]."""
        return self._views.at(stamp, self._frame_id)

    def _locate(
        self,
        tracks: Tracks,
        detections: Detections,
        view: View,
        depth: NDArray[np.float32] | None,
    ) -> None:
        """Locate and publish."""
        with self.lock:
            locations = self._locator.update(tracks, detections, view, depth)
            if self.setup.output.predict_to_now:
                now = self.get_clock().now().nanoseconds
                locations = self._locator.locations(max(now, tracks.stamp))
            locations = replace(locations, frame_id=self.setup.pose.fixed_frame)
            self._output.publish(locations, tracks, self._selector, view.base.t)
        self.health.gave_out(tracks.stamp)

    def _select(self, message: String) -> None:
        try:
            self._selector = Selector(message.data, self.setup.names)
        except ValueError as error:
            self.health.refuse(str(error))

    def _look(self) -> None:
        self._stage.look(lambda: lacks_clock(self))
        self._waiting.look()

    def apply(self, setup: LocatorSetup) -> None:
        """Take changed parameters into use."""
        if setup.config != self.setup.config:
            self._locator.configure(setup.config)
        if setup.output.select != self.setup.output.select:
            self._selector = Selector(setup.output.select, setup.names)
        self._stage.configure(setup.order)
        self._views.configure(setup.pose)


def main() -> int:
    """Run the node."""
    return run(lambda _: [LocatorNode()])
