"""Constant velocity and a known acceleration, such as gravity for tossed balls."""

import numpy as np

from colortrack_ros.estimation.motion.base import Floats
from colortrack_ros.estimation.motion.constant_velocity import ConstantVelocity


class KnownAcceleration(ConstantVelocity):
    """The acceleration is an input (Red object, (1) and (13)).

    Per axis, besides F and Q of constant velocity::

        B u = [dt^2/2] a
              [dt    ]
    """

    def drift(self, dt: float) -> Floats:
        """B u, (4,)."""
        return np.outer([dt**2 / 2, dt], self.acceleration).ravel()
