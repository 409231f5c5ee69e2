"""world: locates tracked objects in meters, given the lens and the pose of the camera."""

from typing import Any
from typing import TYPE_CHECKING

from colortrack_ros.world.camera import CalibrationError
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.config import LocatorConfig
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.poses import PoseBuffer
from colortrack_ros.world.poses import TransformError

if TYPE_CHECKING:
    from colortrack_ros.world.locator import Locator

__all__ = [
    'CalibrationError',
    'CameraModel',
    'Locator',
    'LocatorConfig',
    'Pose',
    'PoseBuffer',
    'TransformError',
]


def __getattr__(name: str) -> Any:
    """Import the locator on first use: SciPy is half of what a follower would import."""
    if name != 'Locator':
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    from colortrack_ros.world.locator import Locator

    return Locator
