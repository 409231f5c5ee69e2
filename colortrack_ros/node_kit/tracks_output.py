"""Publishes the tracks of any tracker."""

from dataclasses import dataclass

from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

from colortrack_ros.data import Tracks
from colortrack_ros.messages import cloud_of_outlines
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.messages import MarkerWriter
from colortrack_ros.node_kit.topics import publish_on
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import parameter


@dataclass(frozen=True)
class TracksOutputConfig(Config):
    """The topics of tracks."""

    marker_scale: float = parameter(
        0.01, 'Size of a pixel in the markers.', unit='m/px', limits=(1e-9, 1e3)
    )
    tracks_topic: str = topic_name('tracks', 'the tracks that are published')
    markers_topic: str = topic_name('tracks/markers', 'the markers that are published')


@dataclass(frozen=True)
class OutlinesOutputConfig(TracksOutputConfig):
    """The topics of tracks with outlines."""

    outlines_topic: str = topic_name('tracks/outlines', 'the outlines that are published')


class TracksOutput:
    """Publishes one message of tracks, one of outlines, if there are any, and one of markers for
    each frame.

    Outlines and markers, which take longer than the tracks, are made only if somebody subscribes.

    :param node: whose tracks they are.
    :ivar alive: number of tracks in the last message.
    """

    def __init__(self, node: Node, config: TracksOutputConfig) -> None:
        self.alive = 0
        self._node, self._writer = node, MarkerWriter()
        self._tracks = publish_on(node, PointCloud2, config.tracks_topic)
        self._markers = publish_on(node, MarkerArray, config.markers_topic)
        self._outlines = (
            publish_on(node, PointCloud2, config.outlines_topic)
            if isinstance(config, OutlinesOutputConfig)
            else None
        )

    def publish(self, tracks: Tracks, marker_scale: float) -> None:
        """Publish the tracks, and log if the tracker has restarted."""
        self.alive = len(tracks.rows)
        if tracks.restarted:
            self._node.get_logger().warning(
                f'The tracker started afresh: {tracks.restarted}', throttle_duration_sec=1.0
            )
        self._tracks.publish(cloud_of_tracks(tracks))
        if self._outlines and self._outlines.get_subscription_count():
            self._outlines.publish(cloud_of_outlines(tracks))
        if self._markers.get_subscription_count():
            self._markers.publish(self._writer.write(tracks, marker_scale))
        else:
            self._writer.skip()
