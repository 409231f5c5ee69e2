"""The node that turns detections into tracks."""

from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

from colortrack_ros.data import Detections
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.messages import detections_of_cloud
from colortrack_ros.messages import MarkerWriter
from colortrack_ros.messages import MessageError
from colortrack_ros.nodes.health import Health
from colortrack_ros.nodes.parameters import declare
from colortrack_ros.nodes.runtime import run
from colortrack_ros.nodes.topics import publish_on
from colortrack_ros.nodes.topics import subscribe_to
from colortrack_ros.nodes.tracker_parameters import build
from colortrack_ros.nodes.tracker_parameters import TABLE
from colortrack_ros.nodes.tracker_parameters import TrackerSetup
from colortrack_ros.tracking import Tracker


class TrackerNode(Node):
    """Detections in, one message of tracks and one of markers for each out.

    :param subscribe: whether detections come from ``detections_topic``, or by :meth:`process`
        alone.
    """

    def __init__(self, *, subscribe: bool = True, **options: Any) -> None:
        super().__init__('tracker', allow_undeclared_parameters=True, **options)
        self._setup: TrackerSetup = declare(self, TABLE, build, self._apply)
        self._tracker = Tracker(self._setup.config)
        self._markers = MarkerWriter()
        self._alive = 0
        self.health = Health(self, tracks=lambda: self._alive)
        self._tracks_publisher = publish_on(self, PointCloud2, 'tracks_topic')
        self._markers_publisher = publish_on(self, MarkerArray, 'markers_topic')
        if subscribe:
            subscribe_to(self, PointCloud2, 'detections_topic', self._receive, pictures=False)

    def process(self, detections: Detections) -> None:
        """Track and publish."""
        self.health.took_in()
        tracks = self._tracker.update(detections)
        self._alive = len(tracks.rows)
        if tracks.restarted:
            self.get_logger().warning(f'The tracker started afresh: {tracks.restarted}')
        self._tracks_publisher.publish(cloud_of_tracks(tracks))
        self._markers_publisher.publish(self._markers.write(tracks, self._setup.marker_scale))
        self.health.gave_out(tracks.stamp)

    def _receive(self, message: PointCloud2) -> None:
        try:
            self.process(detections_of_cloud(message))
        except MessageError as error:
            self.health.refuse(str(error))

    def _apply(self, setup: TrackerSetup) -> None:
        self._setup = setup
        self._tracker.configure(setup.config)


def main() -> int:
    """Run the node."""
    return run(lambda _: [TrackerNode()])
