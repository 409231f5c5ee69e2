"""Two filters side by side, one trusting the measurement, one the model."""

import numpy as np

from colortrack_ros.tracking.motion.base import Floats
from colortrack_ros.tracking.motion.known_acceleration import KnownAcceleration

TRUST = 10.0
"""How many times the process noise is larger, or smaller, than sigma_s."""


class SwitchedPair(KnownAcceleration):
    """The first filter speaks while the object is measured, the second while it is hidden.

    Red object, figure 10: both take every measurement; Q is TRUST^2 sigma_s^2 and
    sigma_s^2 / TRUST^2 times that of constant velocity.
    """

    modes = 2
    selected = True

    def transition(self, dt: float) -> Floats:
        """F, (2, 4, 4), twice the same."""
        return np.repeat(super().transition(dt), 2, axis=0)

    def noise(self, dt: float) -> Floats:
        """Q / sigma_s^2, (2, 4, 4)."""
        return np.array([TRUST**2, TRUST**-2])[:, None, None] * super().noise(dt)
