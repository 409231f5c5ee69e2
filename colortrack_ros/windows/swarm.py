"""Particle swarm optimization of the velocities (Vidal 2009, chapter 5)."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.windows.config import WindowConfig

Particles = NDArray[np.float32]


class Swarm:
    """Finds the velocity on which matching and filter agree best, for all targets at once.

    The cost of a velocity v is its mean squared distance from those that the two have found in the
    last T frames, (5.5) with v in place of the other one::

        V(v) = 1/T sum_t [v_WM,t - v]^2 + [v_K,t - v]^2

    It is quadratic, so its minimum is the mean, which the swarm approaches.

    :param config: see WindowConfig.
    """

    def __init__(self, config: WindowConfig) -> None:
        self._config = config
        self._rng = np.random.default_rng(config.seed)
        first, last = config.swarm_first_inertia, config.swarm_last_inertia
        self._inertia = np.linspace(first, last, config.swarm_iterations).tolist()  # (5.3)

    def search(self, velocity: Floats) -> Floats:
        """Return the best velocity of each target.

        :param velocity: (M, n, 2) found by either in the last frames [px/frame]; NaN where there is
            none. Each target has at least one.
        :return: (M, 2) [px/frame].
        """
        config, known = self._config, ~np.isnan(velocity)
        found = np.where(known, velocity, 0.0)
        target = found.sum(axis=1) / known.sum(axis=1)
        rest = np.where(known, velocity - target[:, None], 0.0)
        low, high = (side.T[..., None].astype(np.float32) for side in (rest.min(1), rest.max(1)))
        # Particles are (2, M, P), relative to the target, to keep the last axis of operations long.
        x = low + self._draw(1, len(target))[0] * (high - low)
        step, best, cost = np.zeros_like(x), x.copy(), x[0] ** 2 + x[1] ** 2
        for weight in self._inertia:
            common = _leading(best, cost)
            own, shared = self._draw(2, len(target)) if config.swarm_random else (1.0, 1.0)
            step *= weight  # (5.2)
            step += config.swarm_own * own * (best - x)
            step += config.swarm_common * shared * (common - x)
            np.minimum(step, config.swarm_max_step, out=step)  # (5.4)
            np.maximum(step, -config.swarm_max_step, out=step)
            x += step  # (5.1)
            new = x[0] ** 2 + x[1] ** 2
            better = new < cost
            np.copyto(best, x, where=better)
            np.copyto(cost, new, where=better)
        return target + _leading(best, cost)[..., 0].T

    def _draw(self, count: int, targets: int) -> Particles:
        shape = count, 2, targets, self._config.swarm_particles
        return self._rng.random(shape, dtype=np.float32)


def _leading(best: Particles, cost: Particles) -> Particles:
    """Return the best place of all particles, (2, M, 1)."""
    return best[:, np.arange(len(cost)), cost.argmin(axis=1)][..., None]
