"""Constant velocity, disturbed by white acceleration."""

from colortrack_ros.estimation.motion.base import Floats
from colortrack_ros.estimation.motion.base import MotionModel
from colortrack_ros.estimation.motion.base import planar


class ConstantVelocity(MotionModel):
    """Piecewise constant acceleration of variance sigma_s^2 (Pegoretti 2021, (2.13)-(2.23)).

    Per axis::

        F = [1  dt]    Q = sigma_s^2 [dt^4/4  dt^3/2]
            [0   1]                  [dt^3/2  dt^2  ]
    """

    def transition(self, dt: float) -> Floats:
        """F, (1, 4, 4), (2.19)."""
        return planar([[1, dt], [0, 1]])[None]

    def noise(self, dt: float) -> Floats:
        """Q / sigma_s^2, (1, 4, 4), (2.23)."""
        return planar([[dt**4 / 4, dt**3 / 2], [dt**3 / 2, dt**2]])[None]
