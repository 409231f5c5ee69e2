"""The bank of Kalman filters: N states in one array (N, n), their covariances in one (N, n, n)."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.tracking.motion import MotionModel

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


class Bank:
    """N filters of one motion model."""

    def __init__(self, model: MotionModel) -> None:
        self.model = model
        self.mean = np.zeros((0, model.size))
        self.cov = np.zeros((0, model.size, model.size))

    def predict(self, dt: float, variance: float) -> None:
        """One step of all filters (Pegoretti 2021, (2.21)-(2.22)).

        F P F^T is linear in the entries of P: with F the same for all, one matrix product.

        :param dt: [s].
        :param variance: sigma_s^2 [px^2/s^4].
        """
        F = self.model.transition(dt)
        FF = np.einsum('ij,kl->ikjl', F, F).reshape(F.size, F.size)
        self.mean = self.mean @ F.T
        self.cov = (self.cov.reshape(-1, F.size) @ FF.T).reshape(self.cov.shape)
        self.cov += variance * self.model.noise(dt)

    def log_likelihood(self, track: Indices, z: Floats, R: Floats) -> Floats:
        """Log of N(z; H x, S), S = H P H^T + R, with its determinant: an uncertain track pays.

        :param track: (K,) which filter.
        :param z: (K, 2) measurement [px].
        :param R: (K, 2, 2) its covariance [px^2].
        :return: (K,).
        """
        e = z - self.mean[track, :2]
        S = self.cov[track, :2, :2] + R
        inverse, det = invert(S)
        d2 = (e[:, None, :] @ inverse @ e[:, :, None])[:, 0, 0]
        return -0.5 * (d2 + np.log(4 * np.pi**2 * det))

    def correct(self, track: Indices, z: Floats, R: Floats) -> None:
        """Estimation, (2.26)-(2.28), with the covariance in Joseph form (Red object, (7)).

        :param track: (K,) which filters, each at most once.
        :param z: (K, 2) measurement [px].
        :param R: (K, 2, 2) its covariance [px^2].
        """
        x, P = self.mean[track], self.cov[track]
        inverse, _ = invert(P[:, :2, :2] + R)
        K = P[:, :, :2] @ inverse
        e = z - x[:, :2]
        A = np.tile(np.eye(self.model.size), (len(track), 1, 1))
        A[:, :, :2] -= K
        P = A @ P @ A.transpose(0, 2, 1) + K @ R @ K.transpose(0, 2, 1)
        self.mean[track] = x + (K @ e[:, :, None])[:, :, 0]
        self.cov[track] = (P + P.transpose(0, 2, 1)) / 2

    def append(self, z: Floats, R: Floats, speed: float) -> None:
        """New filters at rest with an honest doubt about it, (2.24)-(2.25).

        With a wide prior the second detection makes the velocity what two-point differencing makes
        it (Bar-Shalom, Li and Kirubarajan 2001, 5.5.3), with its covariance.

        :param z: (K, 2) first measurement [px].
        :param R: (K, 2, 2) its covariance [px^2].
        :param speed: standard deviation of the first velocity [px/s].
        """
        mean = np.zeros((len(z), self.model.size))
        mean[:, :2] = z
        cov = np.tile(speed**2 * np.eye(self.model.size), (len(z), 1, 1))
        cov[:, :2, :2] = R
        self.mean = np.concatenate([self.mean, mean])
        self.cov = np.concatenate([self.cov, cov])

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Drop the filters where mask, (N,), is False."""
        self.mean, self.cov = self.mean[mask], self.cov[mask]


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
