"""Motion models by name. A new one is a file beside these and a line in MOTION_MODELS."""

from colortrack_ros.tracking.motion.base import MotionModel
from colortrack_ros.tracking.motion.constant_velocity import ConstantVelocity

MOTION_MODELS: dict[str, type[MotionModel]] = {
    'constant_velocity': ConstantVelocity,
}

__all__ = ['MOTION_MODELS', 'MotionModel']
