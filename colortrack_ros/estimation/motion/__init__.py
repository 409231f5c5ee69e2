"""Motion models by name. A new one is a file beside these and a line in MOTION_MODELS."""

from colortrack_ros.estimation.motion.base import MotionModel
from colortrack_ros.estimation.motion.constant_acceleration import ConstantAcceleration
from colortrack_ros.estimation.motion.constant_velocity import ConstantVelocity
from colortrack_ros.estimation.motion.imm import InteractingModels
from colortrack_ros.estimation.motion.known_acceleration import KnownAcceleration
from colortrack_ros.estimation.motion.switched_pair import SwitchedPair

MOTION_MODELS: dict[str, type[MotionModel]] = {
    'constant_velocity': ConstantVelocity,
    'constant_acceleration': ConstantAcceleration,
    'known_acceleration': KnownAcceleration,
    'switched_pair': SwitchedPair,
    'imm': InteractingModels,
}

__all__ = ['MOTION_MODELS', 'MotionModel']
