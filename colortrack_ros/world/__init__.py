"""world: tracks, lens, and pose of the camera -> objects in meters."""

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
    """Import the locator where it is asked for: SciPy is half of what a follower imports."""
    if name != 'Locator':
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    from colortrack_ros.world.locator import Locator

    return Locator
