"""Constant velocity, disturbed by white acceleration."""

import numpy as np
from numpy.typing import NDArray


class ConstantVelocity:
    """Piecewise constant acceleration of variance sigma_s^2 (Pegoretti 2021, (2.13)-(2.23)).

    Per axis, in the order (position, velocity)::

        F = [1  dt]    Q = sigma_s^2 [dt^4/4  dt^3/2]
            [0   1]                  [dt^3/2  dt^2  ]
    """

    size = 4

    def transition(self, dt: float) -> NDArray[np.float64]:
        """F, (4, 4), (2.19)."""
        return np.array([[1, 0, dt, 0], [0, 1, 0, dt], [0, 0, 1, 0], [0, 0, 0, 1]], float)

    def noise(self, dt: float) -> NDArray[np.float64]:
        """Q / sigma_s^2, (4, 4), (2.23): the outer product of what one acceleration does."""
        effect = np.array([[dt**2 / 2, 0, dt, 0], [0, dt**2 / 2, 0, dt]])
        return effect.T @ effect
