"""Publishes located objects."""

from collections.abc import Sequence
from dataclasses import dataclass

from geometry_msgs.msg import PoseArray
from geometry_msgs.msg import PoseStamped
from geometry_msgs.msg import PoseWithCovarianceStamped
from geometry_msgs.msg import TransformStamped
import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

from colortrack_ros.data import Locations
from colortrack_ros.data import Tracks
from colortrack_ros.messages import cloud_of_locations
from colortrack_ros.messages import LocationMarkerWriter
from colortrack_ros.messages import poses_of_locations
from colortrack_ros.messages import target_of_locations
from colortrack_ros.messages.vision import detections_2d_of_tracks
from colortrack_ros.messages.vision import detections_3d_of_locations
from colortrack_ros.messages.vision import vision
from colortrack_ros.node_kit.topics import publish_on
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import parameter
from colortrack_ros.world.selection import Selector


@dataclass(frozen=True)
class LocationsOutputConfig(Config):
    """Topics of the objects, and which object is the target."""

    select: str = parameter(
        'nearest',
        'Which object is the target: nearest, largest, oldest, most_certain, a color, or an ID.',
        int_is_text=True,
    )
    predict_to_now: bool = parameter(
        False, 'Whether objects are published where they are now, not when the picture was taken.'
    )
    target_frame: str = parameter(
        'target', 'The frame of the target in TF, with pose_source tf; empty: none.', read_only=True
    )
    locations_topic: str = topic_name('locations', 'the objects that are published')
    location_markers_topic: str = topic_name('locations/markers', 'the markers in meters')
    poses_topic: str = topic_name('poses', 'the poses of all objects')
    target_pose_topic: str = topic_name('target_pose', 'the pose of the target')
    target_pose_with_covariance_topic: str = topic_name(
        'target_pose_with_covariance', 'the pose of the target, with its covariance'
    )
    detections_2d_topic: str = topic_name(
        'locations/detections_2d', 'the tracks as vision_msgs/Detection2DArray, where that is'
    )
    detections_3d_topic: str = topic_name(
        'locations/detections_3d', 'the objects as vision_msgs/Detection3DArray, where that is'
    )


class LocationsOutput:
    """Publishes the objects of a picture, and the target, on all topics.

    :param names: of the colors.
    :param tf: whether to broadcast the target's frame on TF.
    """

    def __init__(
        self, node: Node, config: LocationsOutputConfig, names: Sequence[str], *, tf: bool
    ) -> None:
        self.alive = 0
        self._names = names
        self._config, self._writer = config, LocationMarkerWriter()
        self._cloud = publish_on(node, PointCloud2, config.locations_topic)
        self._markers = publish_on(node, MarkerArray, config.location_markers_topic)
        self._poses = publish_on(node, PoseArray, config.poses_topic)
        self._pose = publish_on(node, PoseStamped, config.target_pose_topic)
        self._certain = publish_on(
            node, PoseWithCovarianceStamped, config.target_pose_with_covariance_topic
        )
        self._detections_2d = self._detections_3d = None
        if vision:
            self._detections_2d = publish_on(
                node, vision.Detection2DArray, config.detections_2d_topic
            )
            self._detections_3d = publish_on(
                node, vision.Detection3DArray, config.detections_3d_topic
            )
        self._broadcaster = None
        if tf and config.target_frame:
            from tf2_ros import TransformBroadcaster

            self._broadcaster = TransformBroadcaster(node)

    def publish(
        self,
        locations: Locations,
        tracks: Tracks,
        selector: Selector,
        robot: NDArray[np.float64],
    ) -> None:
        """Publish the objects, and the selected one as the target.

        :param tracks: of the picture.
        :param robot: (3,) position of the robot [m].
        """
        self.alive = len(locations.rows)
        self._cloud.publish(cloud_of_locations(locations))
        self._markers.publish(self._writer.write(locations))
        self._poses.publish(poses_of_locations(locations))
        if self._detections_2d and self._detections_2d.get_subscription_count():
            self._detections_2d.publish(detections_2d_of_tracks(tracks, self._names))
        if self._detections_3d and self._detections_3d.get_subscription_count():
            self._detections_3d.publish(detections_3d_of_locations(locations, self._names))
        row = selector.choose(locations, robot)
        if row is None:
            return
        pose, certain = target_of_locations(locations, row)
        self._pose.publish(pose)
        self._certain.publish(certain)
        if self._broadcaster:
            frame = TransformStamped(header=pose.header, child_frame_id=self._config.target_frame)
            where, to = pose.pose.position, frame.transform.translation
            to.x, to.y, to.z = where.x, where.y, where.z
            frame.transform.rotation = pose.pose.orientation
            self._broadcaster.sendTransform(frame)
