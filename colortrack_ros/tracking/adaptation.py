"""What the scene teaches: how fast its objects are, and how unsteady their motion is."""

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FIRST_NOISE, FIRST_SPEED, FIRST_RATE = 300.0, 500.0, 0.5
"""Process noise [px/s^2], speed [px/s] and maneuvers [1/s] to start from."""

NOISE_RANGE = (1.0, 1e5)
RATE_RANGE = (0.01, 20.0)
"""Where the process noise [px/s^2] and the rate of maneuvers [1/s] stay."""

GAIN = 0.2
"""Largest share of a frame in what is learned."""

FEW = 4.0
"""With so many tracks a frame has half of it."""


class Adaptation:
    """Learns from the tracks that have been measured."""

    def __init__(self) -> None:
        self._log_noise = math.log(FIRST_NOISE)
        self._speed2 = FIRST_SPEED**2
        self._nis, self._product = 2.0, 0.0
        self.rate = FIRST_RATE
        """How often an object maneuvers [1/s]."""

    @property
    def noise(self) -> float:
        """sigma_s, standard deviation of the acceleration on each axis [px/s^2]."""
        return math.exp(self._log_noise)

    @property
    def speed(self) -> float:
        """Root mean square of the velocity on each axis [px/s]."""
        return math.sqrt(self._speed2)

    def learn(
        self, nis: Floats, product: Floats, turned: Floats, velocity: Floats, dt: float
    ) -> None:
        """Take the tracks measured in this frame and in the last.

        With the right process noise innovations are white and NIS is 2 on average (Mehra 1970).
        Successive innovations alike say that the filter lags, the noise is too small; opposite
        ones that it is too large. NIS above 2 says too small as well; below 2 it says nothing,
        because the measurement noise may be smaller than given.
        The rate of maneuvers is the share of tracks that made one (expectation-maximization).

        :param nis: (K,) innovations squared, normalized by their covariance.
        :param product: (K,) the same product of each innovation with the one before.
        :param turned: (K,) probability that the track has maneuvered.
        :param velocity: (K, 2) [px/s].
        :param dt: since the last frame [s].
        """
        if not len(nis) or dt <= 0:
            return
        share = GAIN * len(nis) / (len(nis) + FEW)
        calm = (1 - turned) / np.maximum(nis / 10, 1) / len(nis)
        self._nis += share * (float(calm @ nis) - self._nis)
        self._product += share * (float(calm @ product) - self._product)
        drive = self._product / 2 + max(self._nis / 2 - 1, 0.0)
        low, high = map(math.log, NOISE_RANGE)
        self._log_noise = min(max(self._log_noise + share * drive, low), high)
        self._speed2 += (
            share * (float(np.vdot(velocity, velocity)) / velocity.size - self._speed2) / 4
        )
        rate = self.rate + share * (float(turned.sum()) / len(turned) / dt - self.rate)
        self.rate = min(max(rate, RATE_RANGE[0]), RATE_RANGE[1])
