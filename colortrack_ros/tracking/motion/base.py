"""What every motion model gives the bank."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class MotionModel(Protocol):
    """x_k = F x_{k-1} + s_k, z_k = H x_k + w_k, (2.17)-(2.18).

    The state begins with (u, v, du, dv), so that H = [I 0] for every model.
    """

    size: int
    """n, the length of the state."""

    def transition(self, dt: float) -> NDArray[np.float64]:
        """F, (n, n), for a step of dt [s]."""

    def noise(self, dt: float) -> NDArray[np.float64]:
        """Q / sigma_s^2, (n, n), for a step of dt [s]."""
