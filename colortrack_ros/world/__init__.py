"""world: tracks, lens, and pose of the camera -> objects in meters."""

from colortrack_ros.world.camera import CalibrationError
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.poses import PoseBuffer
from colortrack_ros.world.poses import TransformError

__all__ = [
    'CalibrationError',
    'CameraModel',
    'Pose',
    'PoseBuffer',
    'TransformError',
]
