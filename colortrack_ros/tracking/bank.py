"""The bank of Kalman filters: of each mode, N states in one array (N, n), and (N, n, n)."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.tracking.motion import MotionModel

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


class Bank:
    """N tracks, with M filters each; the filters' weights are the probabilities of the modes.

    mean: (M, N, n); cov: (M, N, n, n); weight: (M, N).
    """

    def __init__(self, model: MotionModel) -> None:
        self.model = model
        self.mean = np.zeros((model.modes, 0, model.size))
        self.cov = np.zeros((model.modes, 0, model.size, model.size))
        self.weight = np.zeros((model.modes, 0))

    def __len__(self) -> int:
        return self.weight.shape[1]

    def predict(self, dt: float, variance: float) -> None:
        """One step of all filters (Pegoretti 2021, (2.21)-(2.22)).

        F P F^T is linear in the entries of P: with F the same for all, one matrix product.

        :param dt: [s].
        :param variance: sigma_s^2 [px^2/s^4].
        """
        if self.model.modes > 1 and not self.model.selected:
            self._interact(self.model.switching(dt))
        F = self.model.transition(dt)
        FF = np.einsum('mij,mkl->mikjl', F, F).reshape(len(F), F[0].size, F[0].size)
        flat = self.cov.reshape(len(F), -1, F[0].size)
        self.mean = self.mean @ F.transpose(0, 2, 1) + self.model.drift(dt)
        self.cov = (flat @ FF.transpose(0, 2, 1)).reshape(self.cov.shape)
        self.cov += variance * self.model.noise(dt)[:, None]

    def _interact(self, switching: Floats) -> None:
        """Mix the modes (Blom and Bar-Shalom 1988; Vidal 2009, 2.3.1.2).

        :param switching: (M, M) probability that mode i has become mode j.
        """
        joint = switching[:, :, None] * self.weight[:, None, :]
        self.weight = joint.sum(axis=0)
        share = joint / np.maximum(self.weight, 1e-300)
        self.mean, self.cov = mixture(share, self.mean[:, None], self.cov[:, None])

    def estimate(self) -> tuple[Floats, Floats]:
        """Mean (N, n) and covariance (N, n, n) of each track, over its modes."""
        if self.model.modes == 1:
            return self.mean[0], self.cov[0]
        return mixture(self.weight, self.mean, self.cov)

    def log_likelihoods(self, track: Indices, z: Floats, R: Floats) -> Floats:
        """Log of weight * N(z; H x, S), S = H P H^T + R, of each mode.

        :param track: (K,) which track.
        :param z: (K, 2) measurement [px].
        :param R: (K, 2, 2) its covariance [px^2].
        :return: (M, K).
        """
        e = z - self.mean[:, track, :2]
        density = log_normal(e, self.cov[:, track, :2, :2] + R)
        if self.model.modes == 1:
            return density
        return density + np.log(np.maximum(self.weight[:, track], 1e-300))

    def innovation(self, track: Indices, z: Floats, R: Floats) -> tuple[Floats, Floats]:
        """Of the likeliest mode: e = z - H x, (K, 2), and S^-1 e, (K, 2); see log_likelihoods."""
        mode = self.weight[:, track].argmax(axis=0)
        e = z - self.mean[mode, track, :2]
        inverse, _ = invert(self.cov[mode, track, :2, :2] + R)
        return e, (inverse @ e[:, :, None])[:, :, 0]

    def kick(self, track: Indices, variance: Floats, T: Floats) -> None:
        """Doubt the velocity: it may have changed at any time of the last T seconds alike.

        :param track: (K,) which tracks, each once.
        :param variance: (K,) of the change on each axis [px^2/s^2].
        :param T: (K,) [s].
        """
        for axis in range(2):
            self.cov[:, track, axis, axis] += variance * T**2 / 3
            self.cov[:, track, axis, axis + 2] += variance * T / 2
            self.cov[:, track, axis + 2, axis] += variance * T / 2
            self.cov[:, track, axis + 2, axis + 2] += variance

    def correct(self, track: Indices, z: Floats, R: Floats, share: Floats) -> None:
        """Estimation, (2.26)-(2.28), with the covariance in Joseph form (Red object, (7)).

        A track with several measurements, or a doubtful one, becomes the mixture of what each
        would make of it, replaced by mean and covariance (PDA, Bar-Shalom and Tse 1975).

        :param track: (K,) which tracks, ascending.
        :param z: (K, 2) measurement [px].
        :param R: (K, 2, 2) its covariance [px^2].
        :param share: (K,) probability that it is the track's; what is left is that none is.
        """
        x, P = self.mean[:, track], self.cov[:, track]
        K = P[..., :2] @ invert(P[..., :2, :2] + R)[0]
        step = (K @ (z - x[..., :2])[..., None])[..., 0]
        A = np.broadcast_to(np.eye(self.model.size), P.shape).copy()
        A[..., :2] -= K
        P = A @ P @ A.swapaxes(-1, -2) + K @ R @ K.swapaxes(-1, -2)
        P = (P + P.swapaxes(-1, -2)) / 2
        single = bool((share == 1).all()) and bool((track[1:] != track[:-1]).all())
        if single and (self.model.modes == 1 or self.model.selected):
            self.mean[:, track], self.cov[:, track] = x + step, P
        else:
            self._merge(track, step, P, share * self._posterior(track, z, R), share)
        if self.model.selected:
            measured = np.zeros(len(self), bool)
            measured[track] = True
            self.weight = np.stack([measured, ~measured]).astype(float)

    def _posterior(self, track: Indices, z: Floats, R: Floats) -> Floats:
        """Weights of the modes after each measurement, (M, K)."""
        log = self.log_likelihoods(track, z, R)
        weight = np.exp(log - log.max(axis=0))
        return weight / weight.sum(axis=0)

    def _merge(
        self, track: Indices, step: Floats, P: Floats, weight: Floats, share: Floats
    ) -> None:
        """Replace each mode's mixture over the measurements by its mean and covariance.

        :param step: (M, K, n) from the prediction to each hypothesis.
        :param P: (M, K, n, n) of the hypotheses.
        :param weight: (M, K) of the hypotheses.
        """
        missed = np.ones(len(self))
        np.subtract.at(missed, track, share)
        none = self.weight * np.maximum(missed, 0.0)
        total, shift, spread = none.copy(), np.zeros_like(self.mean), np.zeros_like(self.cov)
        for m in range(self.model.modes):
            np.add.at(total[m], track, weight[m])
            np.add.at(shift[m], track, weight[m, :, None] * step[m])
        scale = np.maximum(total, 1e-300)
        shift /= scale[..., None]
        rest = step - shift[:, track]
        P = weight[..., None, None] * (P + rest[..., :, None] * rest[..., None, :])
        for m in range(self.model.modes):
            np.add.at(spread[m], track, P[m])
        alone = none[..., None, None] * (self.cov + shift[..., :, None] * shift[..., None, :])
        hit = np.unique(track)
        self.mean[:, hit] += shift[:, hit]
        self.cov[:, hit] = ((alone + spread) / scale[..., None, None])[:, hit]
        self.weight = total / total.sum(axis=0)

    def append(self, z: Floats, R: Floats, spread: Floats) -> None:
        """New filters at rest with an honest doubt about it, (2.24)-(2.25).

        With a wide prior the second detection makes the velocity what two-point differencing makes
        it (Bar-Shalom, Li and Kirubarajan 2001, 5.5.3), with its covariance.

        :param z: (K, 2) first measurement [px].
        :param R: (K, 2, 2) its covariance [px^2].
        :param spread: (n,) standard deviations of what is not measured, by element of the state.
        """
        mean = np.zeros((self.model.modes, len(z), self.model.size))
        mean[:, :, :2] = z
        cov = np.broadcast_to(np.diag(spread**2), (*mean.shape, self.model.size)).copy()
        cov[:, :, :2, :2] = R
        start = self.model.switching(1e3)[0]
        weight = np.broadcast_to(start[:, None], mean.shape[:2])
        self.mean = np.concatenate([self.mean, mean], axis=1)
        self.cov = np.concatenate([self.cov, cov], axis=1)
        self.weight = np.concatenate([self.weight, weight], axis=1)

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Drop the tracks where mask, (N,), is False."""
        self.mean, self.cov = self.mean[:, mask], self.cov[:, mask]
        self.weight = self.weight[:, mask]


def mixture(weight: Floats, mean: Floats, cov: Floats) -> tuple[Floats, Floats]:
    """Mean and covariance of Gaussian mixtures over the first axis.

    :param weight: (M, ...), of sum 1; mean: (M, ..., n); cov: (M, ..., n, n).
    """
    weight = weight[..., None]
    center = (weight * mean).sum(axis=0)
    rest = mean - center
    outer = rest[..., :, None] * rest[..., None, :]
    return center, (weight[..., None] * (cov + outer)).sum(axis=0)


def log_normal(e: Floats, S: Floats) -> Floats:
    """Log of the density N(e; 0, S), with its determinant: what is uncertain pays.

    :param e: (..., 2).
    :param S: (..., 2, 2).
    :return: (...).
    """
    inverse, det = invert(S)
    d2 = (e[..., None, :] @ inverse @ e[..., :, None])[..., 0, 0]
    return -0.5 * (d2 + np.log(4 * np.pi**2 * det))


def invert(S: Floats) -> tuple[Floats, Floats]:
    """Inverse and determinant of symmetric 2x2 matrices.

    :param S: (..., 2, 2).
    :return: (..., 2, 2) and (...).
    """
    a, b, c = S[..., 0, 0], S[..., 0, 1], S[..., 1, 1]
    det = a * c - b * b
    inverse = np.empty_like(S)
    inverse[..., 0, 0], inverse[..., 1, 1] = c / det, a / det
    inverse[..., 0, 1] = inverse[..., 1, 0] = -b / det
    return inverse, det
