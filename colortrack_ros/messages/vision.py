"""Tracks and Locations -> vision_msgs, which robots may have but the wheels do not provide."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from colortrack_ros.data import Locations
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import Tracks
from colortrack_ros.messages.header import header_of
from colortrack_ros.messages.targets import covariance_of
from colortrack_ros.messages.targets import pose_of

try:
    from vision_msgs import msg as vision
except ImportError:
    vision = None


def detections_2d_of_tracks(tracks: Tracks, names: Sequence[str]) -> Any:
    """A Detection2DArray: a box [px] for each confirmed or coasting track, its ID as ``id``.

    The pose of its hypothesis, which would be in meters, is not set.

    :param names: of the colors, which are the classes.
    """
    message = vision.Detection2DArray(header=header_of(tracks.stamp, tracks.frame_id))
    for row in tracks.rows[tracks.rows['state'] != TENTATIVE]:
        one = vision.Detection2D(header=message.header, id=str(int(row['track_id'])))
        one.bbox.size_x, one.bbox.size_y = float(row['box_w']), float(row['box_h'])
        one.bbox.center.position.x = float(row['box_u']) + (one.bbox.size_x - 1) / 2
        one.bbox.center.position.y = float(row['box_v']) + (one.bbox.size_y - 1) / 2
        one.results = [_hypothesis_of(row, names)]
        message.detections.append(one)
    return message


def detections_3d_of_locations(locations: Locations, names: Sequence[str]) -> Any:
    """A Detection3DArray: a pose with covariance and a cube [m] for each object, its ID as ``id``.

    If the diameter is unknown, the cube has size 0.

    :param names: of the colors, which are the classes.
    """
    message = vision.Detection3DArray(header=header_of(locations.stamp, locations.frame_id))
    for row in locations.rows[locations.rows['state'] != TENTATIVE]:
        one = vision.Detection3D(header=message.header, id=str(int(row['track_id'])))
        one.bbox.center = pose_of(row)
        size = float(row['diameter'])
        one.bbox.size.x = one.bbox.size.y = one.bbox.size.z = size
        result, covariance = _hypothesis_of(row, names), covariance_of(row)
        result.pose.pose, result.pose.covariance = one.bbox.center, covariance.ravel()
        one.results = [result]
        message.detections.append(one)
    return message


def _hypothesis_of(row: np.void, names: Sequence[str]) -> Any:
    color = int(row['color'])
    result = vision.ObjectHypothesisWithPose()
    result.hypothesis.class_id = names[color] if color < len(names) else str(color)
    result.hypothesis.score = float(row['score'])
    return result
