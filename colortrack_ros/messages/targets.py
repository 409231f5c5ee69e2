"""Locations -> poses and markers, in meters and in the fixed frame (REP-103)."""

import math

from geometry_msgs.msg import Point
from geometry_msgs.msg import Pose
from geometry_msgs.msg import PoseArray
from geometry_msgs.msg import PoseStamped
from geometry_msgs.msg import PoseWithCovarianceStamped
from geometry_msgs.msg import Quaternion
from geometry_msgs.msg import Vector3
import numpy as np
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker
from visualization_msgs.msg import MarkerArray

from colortrack_ros.data import COASTING
from colortrack_ros.data import Locations
from colortrack_ros.data import TENTATIVE
from colortrack_ros.messages.header import header_of

HEADING_SPEED = 0.1
"""Below this speed [m/s] an object has no heading, and its pose has the orientation of the frame.
Twice the speed that 95 % of the objects at rest are estimated below after a second
(test/world/test_filter.py)."""

UNKNOWN_DIAMETER = 0.1
"""Diameter [m] of the marker of an object of unknown size: visible, and it hides nothing."""

ANY_TURN = math.pi**2
"""Variance [rad^2] of an unknown angle: three times that of the uniform distribution, pi^2 / 3."""


def pose_of(row: np.void) -> Pose:
    """The pose of an object, x along its velocity."""
    yaw = (
        math.atan2(row['vy'], row['vx']) if np.hypot(row['vx'], row['vy']) > HEADING_SPEED else 0.0
    )
    return Pose(
        position=Point(x=float(row['x']), y=float(row['y']), z=float(row['z'])),
        orientation=Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2)),
    )


def covariance_of(row: np.void) -> NDArray[np.float64]:
    """Covariance of the pose of an object, (6, 6); its orientation is unknown."""
    covariance = np.zeros((6, 6))
    covariance[:3, :3] = row['covariance'][:3, :3]
    covariance[3:, 3:] = ANY_TURN * np.eye(3)
    return covariance


def poses_of_locations(locations: Locations) -> PoseArray:
    """One pose for each object."""
    return PoseArray(
        header=header_of(locations.stamp, locations.frame_id),
        poses=[pose_of(row) for row in locations.rows],
    )


def target_of_locations(
    locations: Locations, row: int
) -> tuple[PoseStamped, PoseWithCovarianceStamped]:
    """The pose of one object, without and with covariance."""
    header, pose = header_of(locations.stamp, locations.frame_id), pose_of(locations.rows[row])
    certain = PoseWithCovarianceStamped(header=header)
    certain.pose.pose = pose
    certain.pose.covariance = covariance_of(locations.rows[row]).ravel()
    return PoseStamped(header=header, pose=pose), certain


class LocationMarkerWriter:
    """A sphere, an arrow to the predicted position in one second, and a text for each object."""

    def __init__(self) -> None:
        self._shown: set[int] = set()
        self._afresh = True

    def write(self, locations: Locations) -> MarkerArray:
        """The markers, and DELETE for those of objects that are gone.

        The first message has a DELETEALL, for what a locator that was killed has left.
        """
        header = header_of(locations.stamp, locations.frame_id)
        rows = locations.rows[locations.rows['state'] != TENTATIVE]
        shown = set(rows['track_id'].tolist())
        markers = [Marker(header=header, action=Marker.DELETEALL)] * self._afresh
        self._afresh = False
        markers += [
            Marker(header=header, ns=ns, id=gone, action=Marker.DELETE)
            for gone in sorted(self._shown - shown)
            for ns in ('object', 'speed', 'name')
        ]
        self._shown = shown
        for row in rows:
            size = float(row['diameter']) or UNKNOWN_DIAMETER
            color = ColorRGBA(r=0.1, g=0.8, b=0.2, a=0.8)
            if row['state'] == COASTING:
                color = ColorRGBA(r=0.9, g=0.7, b=0.1, a=0.5)
            of = {'header': header, 'id': int(row['track_id']), 'color': color}
            ball = Marker(
                ns='object', type=Marker.SPHERE, scale=Vector3(x=size, y=size, z=size), **of
            )
            ball.pose = pose_of(row)
            arrow = Marker(
                ns='speed', type=Marker.ARROW, scale=Vector3(x=0.02, y=0.05, z=0.0), **of
            )
            start = ball.pose.position
            ahead = {a: getattr(start, a) + float(row[f'v{a}']) for a in 'xyz'}
            arrow.points = [start, Point(**ahead)]
            label = Marker(ns='name', type=Marker.TEXT_VIEW_FACING, scale=Vector3(z=0.15), **of)
            label.pose.position = Point(x=start.x, y=start.y, z=start.z + size)
            label.text = str(int(row['track_id']))
            markers += [ball, arrow, label]
        return MarkerArray(markers=markers)
