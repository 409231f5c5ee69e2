"""Constant acceleration with white-noise jerk."""

from colortrack_ros.data import Floats
from colortrack_ros.estimation.motion.base import MotionModel
from colortrack_ros.estimation.motion.base import planar


class ConstantAcceleration(MotionModel):
    """Proposed by Pegoretti 2021, 5.1; a Wiener process (Bar-Shalom et al. 2001, 6.2.3).

    The acceleration changes by sigma_s (standard deviation) in one second. Per axis::

        F = [1  dt  dt^2/2]    Q = sigma_s^2 [dt^5/20  dt^4/8  dt^3/6]
            [0   1  dt    ]                  [dt^4/8   dt^3/3  dt^2/2]
            [0   0  1     ]                  [dt^3/6   dt^2/2  dt    ]
    """

    size = 6

    def transition(self, dt: float) -> Floats:
        """F, (1, 6, 6)."""
        return planar([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]])[None]

    def noise(self, dt: float) -> Floats:
        """Q / sigma_s^2, (1, 6, 6)."""
        a, b, c, d = dt**4 / 8, dt**3 / 6, dt**3 / 3, dt**2 / 2
        return planar([[dt**5 / 20, a, b], [a, c, d], [b, d, dt]])[None]
