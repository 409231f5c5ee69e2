"""Publishes objects in the world."""

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
from colortrack_ros.messages import cloud_of_locations
from colortrack_ros.messages import LocationMarkerWriter
from colortrack_ros.messages import poses_of_locations
from colortrack_ros.messages import target_of_locations
from colortrack_ros.node_kit.topics import publish_on
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import parameter
from colortrack_ros.world.selection import Selector


@dataclass(frozen=True)
class LocationsOutputConfig(Config):
    """The topics of the objects, and which object is the target."""

    select: str = parameter(
        'nearest',
        'Which object is the target: nearest, largest, oldest, most_certain, a color, or an ID.',
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


class LocationsOutput:
    """Publishes the objects of a picture, and the target, on all topics.

    :param tf: whether there is TF to tell the target's frame to.
    """

    def __init__(self, node: Node, config: LocationsOutputConfig, *, tf: bool) -> None:
        self.alive = 0
        self._config, self._writer = config, LocationMarkerWriter()
        self._cloud = publish_on(node, PointCloud2, config.locations_topic)
        self._markers = publish_on(node, MarkerArray, config.location_markers_topic)
        self._poses = publish_on(node, PoseArray, config.poses_topic)
        self._pose = publish_on(node, PoseStamped, config.target_pose_topic)
        self._certain = publish_on(
            node, PoseWithCovarianceStamped, config.target_pose_with_covariance_topic
        )
        self._broadcaster = None
        if tf and config.target_frame:
            from tf2_ros import TransformBroadcaster

            self._broadcaster = TransformBroadcaster(node)

    def publish(self, locations: Locations, selector: Selector, robot: NDArray[np.float64]) -> None:
        """Publish the objects, and the one that is selected as the target.

        :param robot: (3,) where the robot is [m].
        """
        self.alive = len(locations.rows)
        self._cloud.publish(cloud_of_locations(locations))
        self._markers.publish(self._writer.write(locations))
        self._poses.publish(poses_of_locations(locations))
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
