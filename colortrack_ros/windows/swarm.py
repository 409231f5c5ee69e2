"""Particle swarm optimization of the velocities (Vidal 2009, chapter 5)."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.windows.config import WindowConfig

Floats = NDArray[np.float64]


class Swarm:
    """Searches, for all targets at once, the velocity that matching and filter agree on best.

    The cost of a velocity v is its mean squared distance from those that the two have found in
    the last T frames, (5.5) with v in the place of the other one::

        V(v) = 1/T sum_t [v_WM,t - v]^2 + [v_K,t - v]^2

    It is quadratic, so that its minimum is known, the mean; the swarm comes near it.

    :param config: see WindowConfig.
    """

    def __init__(self, config: WindowConfig) -> None:
        self._config = config
        self._rng = np.random.default_rng(config.seed)

    def search(self, velocity: Floats) -> Floats:
        """The best velocity of each target.

        :param velocity: (M, n, 2) found by either in the last frames [px/frame]; NaN: none. Each
            target has one at least.
        :return: (M, 2) [px/frame].
        """
        config = self._config
        low, high = np.nanmin(velocity, axis=1), np.nanmax(velocity, axis=1)
        target = np.nanmean(velocity, axis=1)[:, None]
        x = low[:, None] + self._draw(1, velocity.shape[0])[0] * (high - low)[:, None]
        step, best = np.zeros_like(x), x.copy()
        cost = _squared(x - target)
        inertia = np.linspace(
            config.swarm_first_inertia, config.swarm_last_inertia, config.swarm_iterations
        )
        for weight in inertia.tolist():
            common = _leading(best, cost)
            own, shared = self._draw(2, len(x)) if config.swarm_random else (1.0, 1.0)
            step *= weight  # (5.2)
            step += config.swarm_own * own * (best - x)
            step += config.swarm_common * shared * (common - x)
            np.clip(step, -config.swarm_max_step, config.swarm_max_step, out=step)  # (5.4)
            x += step  # (5.1)
            new = _squared(x - target)
            better = new < cost
            best[better], cost[better] = x[better], new[better]
        return _leading(best, cost)[:, 0]

    def _draw(self, count: int, targets: int) -> Floats:
        return self._rng.random((count, targets, self._config.swarm_particles, 2))


def _squared(rest: Floats) -> Floats:
    return np.einsum('mpi,mpi->mp', rest, rest)


def _leading(best: Floats, cost: Floats) -> Floats:
    """The best place of all particles, (M, 1, 2)."""
    return np.take_along_axis(best, cost.argmin(axis=1)[:, None, None], axis=1)
