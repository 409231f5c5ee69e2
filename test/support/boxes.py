"""Messages of boxes as networks publish them, serialized by rosbags, which is not our reader."""

from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer
from rosbags.typesys import get_types_from_msg
from rosbags.typesys import get_typestore
from rosbags.typesys import Stores

from colortrack_ros.messages import BOXES

DEFINITIONS = {
    'vision_msgs/msg/Point2D': 'float64 x\nfloat64 y',
    'vision_msgs/msg/Pose2D': 'vision_msgs/Point2D position\nfloat64 theta',
    'vision_msgs/msg/BoundingBox2D': 'vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y',
    'vision_msgs/msg/ObjectHypothesis': 'string class_id\nfloat64 score',
    'vision_msgs/msg/ObjectHypothesisWithPose': (
        'vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose'
    ),
    'vision_msgs/msg/Detection2D': (
        'std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n'
        'vision_msgs/BoundingBox2D bbox\nstring id'
    ),
    BOXES: 'std_msgs/Header header\nvision_msgs/Detection2D[] detections',
}
"""The fields of vision_msgs 4."""

_TYPES = get_typestore(Stores.ROS2_JAZZY)
for _name, _fields in DEFINITIONS.items():
    _TYPES.register(get_types_from_msg(_fields, _name))


def _new(name: str, *values):
    return _TYPES.types[name](*values)


def _pose():
    point = _new('geometry_msgs/msg/Point', 0.0, 0.0, 0.0)
    turn = _new('geometry_msgs/msg/Quaternion', 0.0, 0.0, 0.0, 1.0)
    pose = _new('geometry_msgs/msg/Pose', point, turn)
    return _new('geometry_msgs/msg/PoseWithCovariance', pose, np.zeros(36))


def box(u, v, width, height, results=(('ball', 0.9),), theta=0.0, name=''):
    """The arguments of one Detection2D; results: class and score of each hypothesis."""
    return u, v, width, height, results, theta, name


def serialized(boxes, stamp=0, frame_id='cam', *, little_endian=True) -> bytes:
    """A Detection2DArray of such boxes, in CDR."""
    time = _new('builtin_interfaces/msg/Time', *divmod(stamp, 10**9))
    header = _new('std_msgs/msg/Header', time, frame_id)
    detections = []
    for u, v, width, height, results, theta, name in boxes:
        center = _new('vision_msgs/msg/Pose2D', _new('vision_msgs/msg/Point2D', u, v), theta)
        hypotheses = [_new('vision_msgs/msg/ObjectHypothesis', *result) for result in results]
        kind = 'vision_msgs/msg/ObjectHypothesisWithPose'
        likely = [_new(kind, hypothesis, _pose()) for hypothesis in hypotheses]
        bounds = _new('vision_msgs/msg/BoundingBox2D', center, width, height)
        detections.append(_new('vision_msgs/msg/Detection2D', header, likely, bounds, name))
    message = _new(BOXES, header, detections)
    return bytes(_TYPES.serialize_cdr(message, BOXES, little_endian=little_endian))


def write_boxes(path: Path, topic: str, messages: dict[int, bytes]) -> Path:
    """A bag of such messages, by their time [ns]."""
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        boxes = bag.add_connection(topic, BOXES, typestore=_TYPES)
        for time, cdr in messages.items():
            bag.write(boxes, time, cdr)
    return path
