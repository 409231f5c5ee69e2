"""Constant velocity with white-noise acceleration."""

from colortrack_ros.data import Floats
from colortrack_ros.estimation.motion.base import MotionModel
from colortrack_ros.estimation.motion.base import planar

REFERENCE_PERIOD = 1 / 30
"""Step for which the velocity changes as much as under an acceleration of sigma_s that is constant
within the step [s]. It converts sigma_s [px/s^2] to a spectral density, q = sigma_s^2 / 30."""


class ConstantVelocity(MotionModel):
    """Continuous white-noise acceleration (Bar-Shalom, Li and Kirubarajan 2001, 6.2.2).

    The covariance does not depend on how a time is divided into steps. With
    q = sigma_s^2 REFERENCE_PERIOD, per axis::

        F = [1  dt]    Q = q [dt^3/3  dt^2/2]
            [0   1]          [dt^2/2  dt    ]
    """

    def transition(self, dt: float) -> Floats:
        """F, (1, 4, 4) (Pegoretti 2021, (2.19))."""
        return planar([[1, dt], [0, 1]])[None]

    def noise(self, dt: float) -> Floats:
        """Q / sigma_s^2, (1, 4, 4)."""
        return REFERENCE_PERIOD * planar([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])[None]
