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

    def drift(self, dt: float, acceleration: Floats | None = None) -> Floats:
        """B u, (4,), or (N, 4) by the acceleration of each track."""
        a = np.asarray(self.acceleration) if acceleration is None else acceleration
        return np.concatenate([dt**2 / 2 * a, dt * a], axis=-1)
