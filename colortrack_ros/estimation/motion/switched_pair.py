"""Two filters in parallel, one trusting the measurement, one the model."""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.estimation.motion.known_acceleration import KnownAcceleration


class SwitchedPair(KnownAcceleration):
    """The first filter is used while the object is measured, the second while it is hidden.

    Red object, figure 10: both take every measurement, the first with gains for more process noise
    than there is, the second with gains for less (see trust). Their covariances are those of the
    errors that these gains lead to.
    """

    modes = 2
    selected = True

    def __init__(
        self,
        acceleration: tuple[float, float] = (0.0, 0.0),
        trust: tuple[float, float] = (10.0, 0.1),
    ) -> None:
        super().__init__(acceleration)
        self.trust = trust

    def transition(self, dt: float) -> Floats:
        """F, (2, 4, 4), the same for both."""
        return np.repeat(super().transition(dt), 2, axis=0)

    def noise(self, dt: float) -> Floats:
        """Q / sigma_s^2, (2, 4, 4), the same for both."""
        return np.repeat(super().noise(dt), 2, axis=0)
