"""Motion of targets: Kalman filters, corrected by the swarm (Vidal 2009, 4.3, 5.4)."""

from dataclasses import dataclass

import numpy as np

from colortrack_ros.columns import Columns
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.windows.config import WindowConfig
from colortrack_ros.windows.matching import SUBPIXEL_SIGMA
from colortrack_ros.windows.swarm import Swarm

GATE_SIGMAS, GATE_GROWTH = 3.0, 3.0
"""Standard deviations inside the search region, 99.7 % on each axis, and the factor by which it may
grow at most, to 9 times the area. Assumed; half and twice GATE_SIGMAS change nothing on five scenes
(``benchmark/windows.py --seeds 1 --constants motion.GATE_SIGMAS``)."""

LEAST_T = 1e-3
"""Least time step for a change of velocity [s]: two frames may have the same stamp.
Assumed: far below the interval of any camera's frames."""


@dataclass
class Motion(Columns):
    """The filters of N targets.

    :param bank: constant-velocity filters.
    :param velocity: (N, T, 2, 2) velocities in the last T frames, latest first, by matching and by
        the filter, u and v [px/frame]; NaN where there is none. Input of the swarm.
    """

    bank: Bank
    velocity: Floats

    @classmethod
    def of_new(cls, center: Floats, config: WindowConfig) -> 'Motion':
        """Return filters at rest at the centers of windows, (K, 2) [px]."""
        bank = Bank(MOTION_MODELS['constant_velocity']())
        R = np.broadcast_to(SUBPIXEL_SIGMA**2 * np.eye(2), (len(center), 2, 2))
        spread = np.repeat([0.0, config.initial_speed], 2)
        return cls(bank.at_rest(center, R, spread), _no_velocities(len(center), config))

    def forget_velocities(self, config: WindowConfig) -> None:
        """Clear the velocities that the swarm uses."""
        self.velocity = _no_velocities(len(self), config)

    def predict(self, dt: float, config: WindowConfig) -> Floats:
        """Predict by dt [s] and return where targets are expected.

        WM has no memory of the motion, and expects them where they were last.

        :return: (N, 2) u, v [px].
        """
        if config.method == 'WM':
            self.bank.forget_velocity(config.initial_speed)
        self.bank.predict(dt, config.process_noise**2)
        return self.bank.estimate()[0][:, :2].copy()

    def search_regions(self, config: WindowConfig) -> Floats:
        """Return half the width and height of the search regions, (N, 2) [px]."""
        half = np.array([config.search_width, config.search_height]) / 2
        if config.method == 'WM':
            return np.tile(half, (len(self), 1))
        variance = np.diagonal(self.bank.estimate()[1], axis1=1, axis2=2)[:, :2]
        return np.clip(GATE_SIGMAS * np.sqrt(variance), half, GATE_GROWTH * half)

    def turn(self, track: Indices, innovation: Floats, unmeasured: Floats) -> None:
        """Increase the velocity's covariance of filters that it has led astray.

        :param track: (K,) indices of the filters.
        :param innovation: (K, 2) [px].
        :param unmeasured: (K,) time since their last accepted measurement [s].
        """
        T = np.maximum(unmeasured, LEAST_T)
        self.bank.add_turn(track, T, (np.abs(innovation).max(axis=1) / T) ** 2)
        self.velocity[track] = np.nan

    def steer(self, swarm: Swarm, track: Indices, step: Floats, dt: float) -> None:
        """Set the velocity of filters to the one that the swarm finds, (5.5).

        In the frame of a turn, the filter's own velocity is left out: it does not know when the
        turn was.

        :param track: (K,) indices of the filters.
        :param step: (K, 2) displacement of the match since the last frame [px]; NaN if unknown.
        """
        past = np.roll(self.velocity[track], 1, axis=1)
        turned = np.isnan(past).all(axis=(1, 2, 3)) & ~np.isnan(step[:, 0])
        past[:, 0, 0] = step
        past[:, 0, 1] = np.where(turned[:, None], np.nan, self.bank.mean[0, track, 2:] * dt)
        self.velocity[track] = past
        self.bank.set_velocity(track, swarm.search(past.reshape(len(track), -1, 2)) / dt)


def agreed(steps: Floats) -> Floats:
    """Return the mean, (K, 2), of recent velocities, (K, n, 2), as far as they agree; NaN: none.

    A velocity of mean m and variance s^2 from frame to frame is shrunk by m^2 / (m^2 + s^2), which
    minimizes the squared error. If matches jump about, nothing is left of it.
    """
    known = ~np.isnan(steps).any(axis=(1, 2))
    mean = np.square(steps.mean(axis=1)).sum(axis=1)
    spread = steps.var(axis=1).sum(axis=1)
    share = np.where(known, mean / np.maximum(mean + spread, 1e-9), 0.0)
    return np.asarray(np.nan_to_num(steps.mean(axis=1)) * share[:, None])


def _no_velocities(count: int, config: WindowConfig) -> Floats:
    return np.full((count, config.swarm_frames, 2, 2), np.nan)
