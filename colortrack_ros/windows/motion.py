"""How targets move: Kalman filters, and the swarm that steers them (Vidal 2009, 4.3, 5.4)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Columns
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.windows.config import WindowConfig
from colortrack_ros.windows.matching import SUBPIXEL_SIGMA
from colortrack_ros.windows.swarm import Swarm

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.intp]

GATE_SIGMAS, GATE_GROWTH = 3.0, 3.0
"""The search region holds so many standard deviations, 99.7 % on each axis, up to so many times its
normal size, which is an area 9 times as large. Assumed; half and twice GATE_SIGMAS
change nothing on five scenes (``benchmark/windows.py --seeds 1 --constants
motion.GATE_SIGMAS``)."""

LEAST_T = 1e-3
"""Least time that a change of velocity is told from [s]: two frames may have the same stamp."""


@dataclass
class Motion(Columns):
    """The filters of N targets.

    :param bank: with the model of constant velocity.
    :param velocity: (N, T, 2, 2) in the last T frames, the latest first, by matching and by the
        filter, u and v [px/frame]; NaN: none. The swarm looks at it.
    """

    bank: Bank
    velocity: Floats

    @classmethod
    def of_new(cls, center: Floats, config: WindowConfig) -> 'Motion':
        """Filters that begin at rest in the centers (K, 2) [px] of windows."""
        bank = Bank(MOTION_MODELS['constant_velocity']())
        R = np.broadcast_to(SUBPIXEL_SIGMA**2 * np.eye(2), (len(center), 2, 2))
        spread = np.repeat([0.0, config.initial_speed], 2)
        return cls(bank.at_rest(center, R, spread), _no_velocities(len(center), config))

    def forget_velocities(self, config: WindowConfig) -> None:
        """Let the swarm look back on nothing."""
        self.velocity = _no_velocities(len(self), config)

    def predict(self, dt: float, config: WindowConfig) -> Floats:
        """Go on by dt [s]; WM has no memory of the motion and expects targets where they were last.

        :return: (N, 2) u, v [px].
        """
        if config.method == 'WM':
            self.bank.forget_velocity(config.initial_speed)
        self.bank.predict(dt, config.process_noise**2)
        return self.bank.estimate()[0][:, :2].copy()

    def search_regions(self, config: WindowConfig) -> Floats:
        """Half the width and height of the regions to search, (N, 2) [px]."""
        half = np.array([config.search_width, config.search_height]) / 2
        if config.method == 'WM':
            return np.tile(half, (len(self), 1))
        variance = np.diagonal(self.bank.estimate()[1], axis1=1, axis2=2)[:, :2]
        return np.clip(GATE_SIGMAS * np.sqrt(variance), half, GATE_GROWTH * half)

    def turn(self, track: Indices, innovation: Floats, unmeasured: Floats) -> None:
        """Let filters doubt their velocity where it has led them astray.

        :param track: (K,) which.
        :param innovation: (K, 2) [px].
        :param unmeasured: (K,) time since they were last right [s].
        """
        T = np.maximum(unmeasured, LEAST_T)
        self.bank.add_turn(track, T, (np.abs(innovation).max(axis=1) / T) ** 2)
        self.velocity[track] = np.nan

    def steer(self, swarm: Swarm, track: Indices, step: Floats, dt: float) -> None:
        """Give filters the velocity that the swarm has found, (5.5).

        In the frame of a turn the filter tells none: it cannot know when it was.

        :param track: (K,) which.
        :param step: (K, 2) that the match has made since the last frame [px]; NaN: not known.
        """
        past = np.roll(self.velocity[track], 1, axis=1)
        turned = np.isnan(past).all(axis=(1, 2, 3)) & ~np.isnan(step[:, 0])
        past[:, 0, 0] = step
        past[:, 0, 1] = np.where(turned[:, None], np.nan, self.bank.mean[0, track, 2:] * dt)
        self.velocity[track] = past
        self.bank.set_velocity(track, swarm.search(past.reshape(len(track), -1, 2)) / dt)


def _no_velocities(count: int, config: WindowConfig) -> Floats:
    return np.full((count, config.swarm_frames, 2, 2), np.nan)
