"""Constant velocity with a known acceleration, such as gravity for tossed balls."""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.estimation.motion.constant_velocity import ConstantVelocity


class KnownAcceleration(ConstantVelocity):
    """The acceleration is a control input (Red object, (1) and (13)).

    Per axis, in addition to F and Q of constant velocity::

        B u = [dt^2/2] a
              [dt    ]
    """

    def drift(self, dt: float, acceleration: Floats | None = None) -> Floats:
        """B u, (4,), or (N, 4) where each track has its own acceleration."""
        a = np.asarray(self.acceleration) if acceleration is None else acceleration
        return np.concatenate([dt**2 / 2 * a, dt * a], axis=-1)
