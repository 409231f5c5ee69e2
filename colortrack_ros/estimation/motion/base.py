"""The interface of motion models."""

from abc import ABC
from abc import abstractmethod
from collections.abc import Sequence

import numpy as np

from colortrack_ros.data import Floats

BOTH = np.eye(2)[:, None]
"""Expands matrices of one axis to two independent axes."""


class MotionModel(ABC):
    """x_k = F x_{k-1} + B u + s_k, z_k = H x_k + w_k (Pegoretti 2021, (2.17)-(2.18)).

    The state begins with (u, v, du, dv), so that H = [I 0] for every model. A model may have
    several modes, filters side by side for the same track.

    :param acceleration: (u, v), known in advance [px/s^2]; most models ignore it.
    :param trust: see the attribute; most models ignore it.
    """

    size = 4
    """n, the dimension of the state."""

    modes = 1
    """M, the number of filters a track has."""

    selected = False
    """Whether one mode is used at a time: the first while the track is measured, else the last."""

    trust: tuple[float, ...] | None = None
    """(M,) ratio of the process noise that a mode's gain assumes to that of its covariance."""

    def __init__(
        self,
        acceleration: tuple[float, float] = (0.0, 0.0),
        trust: tuple[float, float] = (10.0, 0.1),
    ) -> None:
        self.acceleration = acceleration

    @abstractmethod
    def transition(self, dt: float) -> Floats:
        """F, (M, n, n), for a step of dt [s]."""

    @abstractmethod
    def noise(self, dt: float) -> Floats:
        """Q / sigma_s^2, (M, n, n), for a step of dt [s]."""

    def drift(self, dt: float, acceleration: Floats | None = None) -> Floats:
        """B u, for a step of dt [s].

        :param acceleration: (N, 2) of each track [px/s^2]; None for the one known in advance.
        :return: (N, n), or (n,) for all tracks.
        """
        return np.zeros(self.size)

    def switching(self, dt: float) -> Floats:
        """Transition probabilities from mode i to mode j after dt [s], (M, M)."""
        return np.eye(self.modes)


def planar(axis: Sequence[Sequence[float]]) -> Floats:
    """The same matrix for both axes, in the order (u, v, du, dv, ...).

    :param axis: (n/2, n/2) for one axis: position, velocity, ...
    :return: (n, n).
    """
    k = len(axis)
    both = np.array(axis, float)[:, None, :, None] * BOTH
    return both.reshape(2 * k, 2 * k)
