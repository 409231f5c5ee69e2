"""Interacting multiple models: constant acceleration and constant velocity with large noise."""

import math

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.estimation.motion.base import MotionModel
from colortrack_ros.estimation.motion.base import planar
from colortrack_ros.estimation.motion.constant_acceleration import ConstantAcceleration
from colortrack_ros.estimation.motion.constant_velocity import ConstantVelocity

SMOOTH, ROUGH = 1.0, 0.25
"""Mean sojourn times of smooth and of rough motion [s]. Assumed: about the flight of a juggled
ball, and its time in the hand. On juggled balls, a tenth of them missed, IDF1 is 98.0 with 20
switches; with half and twice the first 98.6, 14 and 98.0, 20, the second 98.0, 16 and 98.0, 22."""

CALM = 0.3
"""Process noise of the smooth mode over sigma_s. Assumed; half and twice give 98.0, 20 and 97.9, 16
on the same balls."""


class InteractingModels(MotionModel):
    """Blom and Bar-Shalom 1988 (Vidal 2009, 2.3.1.2).

    Mode 0, flight, is constant acceleration with little noise. Mode 1, a hand, a bounce or a turn,
    is constant velocity with sigma_s, its acceleration reset to zero.
    """

    size = 6
    modes = 2

    def transition(self, dt: float) -> Floats:
        """F, (2, 6, 6)."""
        smooth = ConstantAcceleration().transition(dt)
        rough = planar([[1, dt, 0], [0, 1, 0], [0, 0, 0]])
        return np.concatenate([smooth, rough[None]])

    def noise(self, dt: float) -> Floats:
        """Q / sigma_s^2, (2, 6, 6)."""
        smooth = CALM**2 * ConstantAcceleration().noise(dt)
        rough = np.eye(6)
        rough[:4, :4] = ConstantVelocity().noise(dt)[0]
        return np.concatenate([smooth, rough[None]])

    def switching(self, dt: float) -> Floats:
        """Of a continuous-time Markov process with mean sojourn times SMOOTH and ROUGH."""
        mixed = -math.expm1(-dt * (1 / SMOOTH + 1 / ROUGH))
        rough = mixed * ROUGH / (SMOOTH + ROUGH)
        smooth = mixed * SMOOTH / (SMOOTH + ROUGH)
        return np.array([[1 - rough, rough], [smooth, 1 - smooth]])
