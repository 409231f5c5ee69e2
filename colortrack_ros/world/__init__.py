"""world: tracks, lens, and pose of the camera -> objects in meters."""

from colortrack_ros.world.camera import CalibrationError
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.locator import Locator
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.poses import PoseBuffer
from colortrack_ros.world.poses import TransformError

__all__ = [
    'CalibrationError',
    'CameraModel',
    'Locator',
    'LocatorConfig',
    'Pose',
    'PoseBuffer',
    'TransformError',
]
