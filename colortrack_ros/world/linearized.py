"""One linearized update of objects, conditional on the camera errors."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from colortrack_ros.columns import Columns
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.world.inverse_depth import to_points
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import predicted
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.view import View
from colortrack_ros.world.whitening import whitening

FARTHER = 4.0
"""Largest factor by which one update step may increase the range of an object: the linearization
does not hold beyond, where 1/Z comes near 0. Chosen."""


@dataclass
class Linearized(Columns):
    """States of N objects, updated by M measurements that are linearized at one point each.

    :ivar H: (N, M, 8) derivative of the measurements by the state.
    :ivar direct: (N, M, 9 C) their derivative by the camera errors, with states fixed.
    :ivar visible: (N,) whether the camera sees the object at that point.
    :ivar G: (N, 2, M, 9 C) derivative of the innovations by the camera errors.
    :ivar off: (N, 2, M) predicted minus measured values.
    :ivar S: (N, 2, M, M) covariance of the innovations; W: its whitening matrix, of the same shape;
        volume: (N, 2) its log determinant.
    :ivar seen: (N, 2, M, 8 + 9 C + 1) whitened: the cross-covariance with the states, G, and the
        innovations with opposite sign.
    :ivar gain: (N, 2, 8, M) of whitened innovations.
    :ivar ahead: (N, 8) mean of the updated states.
    """

    H: Floats
    direct: Floats
    visible: Bools
    G: Floats
    off: Floats
    S: Floats
    W: Floats
    volume: Floats
    seen: Floats
    gain: Floats
    states: Motions
    ahead: Floats


@dataclass
class Prior(Columns):
    """States of N objects in inverse depth, and what is measured of them.

    :ivar known: (N, 9 C) estimated camera errors; P: (N, 9 C, 9 C) their covariance.
    :ivar ground: its height in the fixed frame [m].
    :ivar rows: the M measured rows.
    """

    states: Motions
    known: Floats
    P: Floats
    measured: Measured
    kinds: Kinds
    view: View
    ground: float
    camera: int
    rows: list[int]

    @cached_property
    def some(self) -> list[int] | slice:
        """These rows, as a slice where they are the first ones."""
        count = len(self.rows)
        return slice(count) if self.rows == list(range(count)) else self.rows

    @property
    def R(self) -> Floats:
        """Covariance of the measurements, (N, 1, M, M)."""
        some = self.some
        return self.measured.R[:, None, some][..., some]

    def updated(self, at: Floats) -> Linearized:
        """Return the update by measurements that are linearized at these states, (N, 8)."""
        prior, falls = self.states, self.kinds.falls
        H, rest, visible = self._linearized(at)
        beside, by_state = prior.whole.copy(), H[:, None]
        beside[..., -1] -= at[:, None]
        innovations = by_state @ beside
        innovations[..., OF_OBJECT:] += rest[:, None]
        S = by_state @ innovations[..., :OF_OBJECT].swapaxes(-1, -2) + self.R
        W, volume = whitening(S)
        seen = W @ innovations
        gain = seen[..., :OF_OBJECT].swapaxes(-1, -2)
        if np.count_nonzero(falls):
            P = self.P * falls[:, None, None]
            gain = _considered(gain, prior.slope, seen[..., OF_OBJECT:-1], P)
        states = Motions(prior.whole - gain @ seen, prior.probability)
        states.mean[..., 2] = np.maximum(states.mean[..., 2], prior.mean[..., 2] / FARTHER)
        ahead = (prior.probability[:, None] @ states.mean)[:, 0]
        G, off = innovations[..., OF_OBJECT:-1], innovations[..., -1]
        return Linearized(
            H, rest[..., :-1], visible, G, off, S, W, volume, seen, gain, states, ahead
        )

    def _linearized(self, at: Floats) -> tuple[Floats, Floats, Bools]:
        """Return the derivative of the measurements by the states, (N, M, 8), the one by the camera
        errors beside predicted minus measured values, (N, M, 9 C + 1), and what is visible, (N,).
        """
        state = at.copy()
        state[:, POSITION], J = to_points(self.view.optical, at[:, POSITION])
        H, rest = predicted(
            self.view, state, self.known, self.kinds, self.ground, self.camera, BLOB in self.rows
        )
        H[:, :, POSITION] = H[:, :, POSITION] @ J
        rest[:, :, -1] -= self.measured.z
        some = self.some
        H, rest, unused = H[:, some], rest[:, some], ~self.measured.used[:, some]
        visible = np.asarray(np.isfinite(rest.sum(axis=(1, 2)) + H.sum(axis=(1, 2))))
        unused |= ~visible[:, None]
        H[unused], rest[unused] = 0.0, 0.0
        return H, rest, visible


def _considered(PH: Floats, slope: Floats, G: Floats, P: Floats) -> Floats:
    """Return the Schmidt-Kalman gain, (N, 2, 8, M), which considers the camera errors.

    Used for falling objects, whose bounces are too nonlinear for the conditional gain: their
    covariance would hold only if the camera errors were as estimated.

    :param PH: (N, 2, 8, M) Kalman gain for known errors, of whitened innovations.
    :param G: (N, 2, M, 9 C) derivative of the whitened innovations by the camera errors.
    :param P: (N, 9 C, 9 C) covariance of the camera errors, 0 for objects that do not fall.
    """
    PG = P[:, None] @ G.swapaxes(-1, -2)
    S = np.eye(G.shape[-2]) + G @ PG
    return np.linalg.solve(S, (PH + slope @ PG).swapaxes(-1, -2)).swapaxes(-1, -2)
