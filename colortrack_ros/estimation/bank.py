"""The bank of Kalman filters: for each mode, N states in one array (N, n), and (N, n, n)."""

import numpy as np

from colortrack_ros.columns import Columns
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.gaussian import invert
from colortrack_ros.estimation.gaussian import joseph
from colortrack_ros.estimation.gaussian import maneuvering
from colortrack_ros.estimation.gaussian import mixture
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.estimation.motion import MotionModel
from colortrack_ros.estimation.track_table import marked

LEAST_WEIGHT = 1e-12
"""Least weight of a mode, so that it can recover: one measurement 7.4 standard deviations from what
the other modes predict has a likelihood ratio of exp(7.4^2/2), which outweighs it."""

SETTLED = 1e3
"""Time after which the modes have reached their stationary weights, with which new tracks start
[s]; the mean sojourn time of the IMM's modes is at most 1 s."""

MOST_STEPS = 8
"""Step lengths whose matrices are cached: at a steady rate, rounded stamps give two."""


class Bank(Columns):
    """N tracks, with M filters each; the filters' weights are the probabilities of the modes.

    :param model: how the tracks move.
    :ivar mean: (M, N, n).
    :ivar cov: (M, N, n, n).
    :ivar weight: (M, N).
    :ivar design: (M, N, n, n) covariances of a model whose gains assume other process noise than
        there is (see MotionModel.trust); None for all other models.
    """

    axis = 1

    def __init__(self, model: MotionModel) -> None:
        self.model = model
        self.mean = np.zeros((model.modes, 0, model.size))
        self.cov = np.zeros((model.modes, 0, model.size, model.size))
        self.weight = np.zeros((model.modes, 0))
        self.design = None if model.trust is None else self.cov.copy()
        self._by_dt: dict[float, tuple[Floats, Floats, Floats]] = {}

    def predict(
        self, dt: float, variance: float | Floats, acceleration: Floats | None = None
    ) -> None:
        """Predict all filters (Pegoretti 2021, (2.21)-(2.22)).

        F P F^T is linear in the entries of P; with one F for all tracks it is one matrix product.

        :param dt: [s].
        :param variance: sigma_s^2 [px^2/s^4], of all tracks, or of each, (N, 1), or (N, 2) by axis.
        :param acceleration: (N, 2) known acceleration of each track [px/s^2]; None for the model's.
        """
        if self.model.modes > 1 and not self.model.selected:
            self._interact(self.model.switching(dt))
        F, FF, Q = self._matrices(dt)
        if isinstance(variance, np.ndarray):
            if variance.shape[1] == 2:
                variance = np.concatenate([variance] * (self.model.size // 2), axis=1)
            variance = variance[..., None]
        Q = Q * variance
        modes, n = len(F), self.model.size
        self.mean = self.mean @ F + self.model.drift(dt, acceleration)
        self.cov = (self.cov.reshape(modes, -1, n * n) @ FF).reshape(self.cov.shape) + Q
        if self.design is not None:
            Q = np.square(self.model.trust or ())[:, None, None, None] * Q
            self.design = (self.design.reshape(modes, -1, n * n) @ FF).reshape(self.cov.shape)
            self.design += Q

    def _matrices(self, dt: float) -> tuple[Floats, Floats, Floats]:
        """F^T, F (x) F transposed, and Q / sigma_s^2 for a step of dt [s], cached by dt."""
        if dt not in self._by_dt:
            if len(self._by_dt) == MOST_STEPS:
                self._by_dt.clear()
            F, (modes, n) = self.model.transition(dt), (self.model.modes, self.model.size)
            FF = F[:, :, None, :, None] * F[:, None, :, None, :]
            FF = FF.reshape(modes, n * n, n * n).swapaxes(1, 2)
            self._by_dt[dt] = F.swapaxes(1, 2), FF, self.model.noise(dt)[:, None]
        return self._by_dt[dt]

    def _interact(self, switching: Floats) -> None:
        """Mix the modes (Blom and Bar-Shalom 1988; Vidal 2009, 2.3.1.2).

        :param switching: (M, M) transition probabilities from mode i to mode j.
        """
        joint = switching[:, :, None] * self.weight[:, None, :]
        self.weight = joint.sum(axis=0)
        share = joint / np.maximum(self.weight, TINY)
        self.mean, self.cov = mixture(share, self.mean[:, None], self.cov[:, None])

    def estimate(self) -> tuple[Floats, Floats]:
        """Mean (N, n) and covariance (N, n, n) of each track, over its modes."""
        if self.model.modes == 1:
            return self.mean[0], self.cov[0]
        return mixture(self.weight, self.mean, self.cov)

    def maneuver(self, track: Indices, weight: Floats, T: Floats, speed: Floats) -> None:
        """Replace predictions by the mixture of no maneuver and a maneuver.

        :param track: (K,) tracks, each once.
        :param weight: (K,) probability of the maneuver.
        :param T: (K,) [s].
        :param speed: (2,), (1, 2), or (K, 2) standard deviation of the new velocity [px/s].
        """
        mean, cov = self.mean.take(track, axis=1), self.cov.take(track, axis=1)
        self.mean[:, track], self.cov[:, track] = maneuvering(mean, cov, weight, T, speed)

    def spread(self, track: Indices, variance: Floats) -> None:
        """Add to the variances of predicted positions, and to nothing else.

        :param track: (K,) tracks, each once.
        :param variance: (K, 2) on each axis [px^2].
        """
        for axis in (0, 1):
            self.cov[:, track, axis, axis] += variance[:, axis]

    def correct(self, track: Indices, z: Floats, R: Floats, share: Floats | None = None) -> None:
        """Update, (2.26)-(2.28), with the covariance in Joseph form (Red object, (7)).

        With several measurements, or an uncertain one, a track becomes the mixture of the updates
        by each, reduced to its mean and covariance (PDA, Bar-Shalom and Tse 1975).

        :param track: (K,) tracks, ascending; each once if share is None.
        :param z: (K, 2) measurements [px].
        :param R: (K, 2, 2) their covariances [px^2].
        :param share: (K,) probability that the measurement is the track's; the rest of 1 is the
            probability that none is.
        """
        every = share is None and len(track) == self.mean.shape[1]
        rows: Indices | slice = slice(None) if every else track
        x, cov = self.mean, self.cov
        if not every:
            x, cov = x.take(track, axis=1), cov.take(track, axis=1)
        design = cov if self.design is None else self.design[:, rows]
        inverse, det = invert(design[..., :2, :2] + R)
        K = design[..., :2] @ inverse
        e = (z - x[..., :2])[..., None]
        step = (K @ e)[..., 0]
        P = joseph(cov, K, R)
        if self.design is not None:
            self.design[:, rows] = joseph(design, K, R)
        if share is None and (len(x) == 1 or self.model.selected):
            self.mean[:, rows], self.cov[:, rows] = x + step, P
        else:
            d2 = (e.swapaxes(-1, -2) @ inverse @ e)[..., 0, 0]
            log = np.log(np.maximum(self.weight[:, rows], TINY)) - 0.5 * (d2 + np.log(det))
            weight = np.maximum(np.exp(log - np.maximum.reduce(log)), LEAST_WEIGHT)
            weight /= np.add.reduce(weight)
            if share is None:
                self.mean[:, rows], self.cov[:, rows], self.weight[:, rows] = x + step, P, weight
            else:
                self._merge(track, step, P, share * weight, share)
        if self.model.selected:
            measured = marked(track, self.weight.shape[1])
            self.weight = np.stack([measured, ~measured]).astype(float)

    def _merge(
        self, track: Indices, step: Floats, P: Floats, weight: Floats, share: Floats
    ) -> None:
        """Replace each mode's mixture over the measurements by its mean and covariance.

        :param step: (M, K, n) from the prediction to each hypothesis.
        :param P: (M, K, n, n) of the hypotheses.
        :param weight: (M, K) of the hypotheses.
        :param share: (K,) their sum over the modes.
        """
        hit, place = np.unique(track, return_inverse=True)
        missed = np.maximum(1 - np.bincount(place, share), 0.0)
        none = self.weight[:, hit] * missed
        total, shift = none.copy(), np.zeros_like(self.mean[:, hit])
        where = np.arange(len(weight))[:, None], place
        np.add.at(total, where, weight)
        np.add.at(shift, where, weight[..., None] * step)
        total = np.maximum(total, TINY)
        shift /= total[..., None]
        rest = step - shift[:, place]
        spread = none[..., None, None] * (
            self.cov[:, hit] + shift[..., :, None] * shift[..., None, :]
        )
        P = weight[..., None, None] * (P + rest[..., :, None] * rest[..., None, :])
        np.add.at(spread, where, P)
        self.mean[:, hit] += shift
        self.cov[:, hit] = spread / total[..., None, None]
        self.weight[:, hit] = total / total.sum(axis=0)

    def at_rest(self, z: Floats, R: Floats, spread: Floats) -> 'Bank':
        """Filters of new tracks: zero velocity with a wide prior, (2.24)-(2.25).

        With a wide prior the second detection gives the velocity and covariance of two-point
        differencing (Bar-Shalom, Li and Kirubarajan 2001, 5.5.3).

        :param z: (K, 2) first measurement [px].
        :param R: (K, 2, 2) its covariance [px^2].
        :param spread: (n,) standard deviations of the unmeasured elements of the state.
        :return: a bank of the same model, to extend this one by.
        """
        new = Bank(self.model)
        new.mean = np.zeros((self.model.modes, len(z), self.model.size))
        new.mean[:, :, :2] = z
        new.cov = np.zeros((*new.mean.shape, self.model.size))
        new.cov[:] = np.diag(spread**2)
        new.cov[:, :, :2, :2] = R
        new.design = None if self.design is None else new.cov.copy()
        weight = self.model.switching(SETTLED)[0][:, None]
        new.weight = np.zeros(new.mean.shape[:2]) + weight
        return new

    def move(self, A: Floats, shift: Floats, variance: float) -> None:
        """Move all tracks with the camera's motion: x -> A x + shift.

        :param A: (N, 2, 2) rotation, scale and shear.
        :param shift: (N, 2) [px].
        :param variance: of the shift, on each axis [px^2].
        """
        G = np.zeros((len(A), self.model.size, self.model.size))
        for at in range(0, self.model.size, 2):
            G[:, at : at + 2, at : at + 2] = A
        self.mean = (G @ self.mean[..., None])[..., 0]
        self.mean[..., :2] += shift
        self.cov = G @ self.cov @ G.swapaxes(1, 2)
        self.cov[..., (0, 1), (0, 1)] += variance
        if self.design is not None:
            self.design = G @ self.design @ G.swapaxes(1, 2)

    def accelerate(self, velocity: Floats) -> None:
        """Add to the velocities of all tracks, (N, 2) [px/s]."""
        self.mean[..., 2:4] += velocity

    def set_speed(self, speed: Floats) -> None:
        """Change the velocity prior of filters that have had one measurement.

        :param speed: (2,) standard deviation on each axis [px/s].
        """
        for cov in (self.cov, self.design):
            if cov is not None:
                cov[:, :, (2, 3), (2, 3)] = speed**2

    def forget_velocity(self, speed: float) -> None:
        """Set all velocities to zero with a wide prior; positions stay.

        :param speed: standard deviation on each axis [px/s].
        """
        self.mean[..., 2:] = 0
        self.cov[..., 2:, :] = self.cov[..., :, 2:] = 0
        self.cov[..., (2, 3), (2, 3)] = speed**2

    def set_velocity(self, track: Indices, velocity: Floats) -> None:
        """Replace the velocities of tracks, (K,), by (K, 2) [px/s]; covariances stay."""
        self.mean[:, track, 2:4] = velocity

    def doubt(self, track: Indices, factor: Floats) -> None:
        """Inflate the covariances of tracks, (K,), whose measurements were trusted too much.

        :param factor: (K,) by which the covariance of their measurements has grown.
        """
        for cov in (self.cov, self.design):
            if cov is not None:
                cov[:, track] *= factor[:, None, None]

    def doubt_velocity(self, track: Indices, variance: Floats) -> None:
        """Add to the velocity variances of tracks.

        :param track: (K,) tracks.
        :param variance: (K, 2) by axis [px^2/s^2].
        """
        self.cov[:, track[:, None], (2, 3), (2, 3)] += variance

    def add_turn(self, track: Indices, T: Floats, variance: Floats) -> None:
        """Allow for a change of velocity at a time uniformly distributed over the last T.

        It adds variance T^2/3 to the position, correlated with the velocity.

        :param track: (K,) tracks.
        :param T: (K,) [s].
        :param variance: (K,) of the change of velocity on each axis [px^2/s^2].
        """
        for axis in range(2):
            self.cov[:, track, axis, axis] += variance * T**2 / 3
            self.cov[:, track, axis, axis + 2] += variance * T / 2
            self.cov[:, track, axis + 2, axis] += variance * T / 2
            self.cov[:, track, axis + 2, axis + 2] += variance
