"""Filters of motion and shape, for all targets at once.

The state of a target is its nodes X, (n, 2) [px], and its motion M = (u, v, s, r): velocity of the
center [px/frame], change of scale and angular velocity [1/frame]. With H of (6), a row for each
node (I, X - C, and X - C turned by a right angle)::

    X_k = X_{k-1} + T H M_k + w,  M_k = M_{k-1} + q,  z_i = n_i (X_i - X'_i) + v

(De Bem 2007, (4)-(8)), where T is the time step in frames, n_i the normal of line i, and z_i the
place of its edge. A line says nothing about motion along the contour.

The Kalman bank does not fit: its filters measure a position, (u, v), and share one transition
matrix; here n scalars are measured along normals, and each target has its own H.
"""

from dataclasses import dataclass

import numpy as np

from colortrack_ros.columns import Columns
from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices

MOTION_SIZE = 4
"""Components of M."""

NO_EDGE_VARIANCE = 1e12
"""Variance of a missing measurement [px^2]: a sigma of 1e6 px, beyond any picture."""

NODE_SIGMA, MOTION_SIGMA = 2.0, np.array([1.0, 1.0, 1e-2, 1e-2])
"""Initial standard deviations of a node [px], by which a blur of 1.5 px and an opening by 1 px to
each side move an outline, and of M [px/frame, 1/frame]. Mean squared errors of `silhouette` and
`approach`, 0.064 and 0.023 px^2, become 0.025 to 0.067 and 0.021 to 0.037 with half and twice
NODE_SIGMA, 0.029 to 0.064 and 0.022 to 0.024 with those of MOTION_SIGMA (``benchmark/contours.py
--constants filters.NODE_SIGMA filters.MOTION_SIGMA``)."""


@dataclass
class Contours(Columns):
    """N targets with n nodes each.

    :ivar nodes: (N, n, 2) [px].
    :ivar motion: (N, MOTION_SIZE).
    :ivar cov: (N, 2n + MOTION_SIZE, 2n + MOTION_SIZE) of nodes (u and v in turn) and motion.
    :ivar node_design: (N, n) P_X of (8) for each coordinate; only for filters `two`.
    :ivar motion_design: (N, MOTION_SIZE, MOTION_SIZE) P_M of (7); only for filters `two`.
    :ivar sides: (N, n, 2) usual intensities just inside and outside of each edge [levels], NaN
        while unknown.
    """

    nodes: Floats
    motion: Floats
    cov: Floats
    node_design: Floats
    motion_design: Floats
    sides: Floats

    @classmethod
    def new(cls, nodes: Floats, velocity: Floats, config: ContourConfig) -> 'Contours':
        """Return new targets with nodes (N, n, 2) and velocities (N, 2) [px/frame]."""
        count, n = nodes.shape[:2]
        motion = np.zeros((count, MOTION_SIZE))
        motion[:, :2] = velocity
        spread = np.concatenate([np.full(2 * n, NODE_SIGMA), MOTION_SIGMA])
        spread[-1] *= config.rotation
        cov = np.tile(np.diag(spread**2), (count, 1, 1))
        return cls(
            nodes.copy(),
            motion,
            cov,
            np.full((count, n), config.edge_variance),
            cov[:, 2 * n :, 2 * n :].copy(),
            np.full(nodes.shape, np.nan),
        )

    def doubt_velocity(self, sigma: float) -> None:
        """Set the standard deviation of velocities that are as good as unknown [px/frame]."""
        u = 2 * self.nodes.shape[1]
        self.cov[:, [u, u + 1], [u, u + 1]] = sigma**2
        self.motion_design[:, [0, 1], [0, 1]] = sigma**2

    def renewed(self, which: Indices, nodes: Floats, config: ContourConfig) -> 'Contours':
        """Return targets `which`, (K,), with new nodes, (K, n, 2), and their current motion."""
        new, n = Contours.new(nodes, self.motion[which, :2], config), nodes.shape[1]
        new.motion[:] = self.motion[which]
        new.cov[:, 2 * n :, 2 * n :] = self.cov[which, 2 * n :, 2 * n :]
        new.motion_design[:] = self.motion_design[which]
        return new

    def predict(self, T: float, config: ContourConfig) -> None:
        """Predict by (4), with the joint covariance of nodes and motion."""
        count, n = self.nodes.shape[:2]
        H = T * motion_matrix(self.nodes)
        self.nodes += (H @ self.motion[..., None]).reshape(count, n, 2)
        noise = np.full(2 * n + MOTION_SIZE, config.shape_noise)
        noise[2 * n :] = motion_noise(config)
        # F P F^T with F = [I H; 0 I]
        self.cov[:, : 2 * n] += H @ self.cov[:, 2 * n :]
        self.cov[:, :, : 2 * n] += self.cov[:, :, 2 * n :] @ H.swapaxes(1, 2)
        diagonal = np.arange(2 * n + MOTION_SIZE)
        self.cov[:, diagonal, diagonal] += T * noise
        self.node_design += T * config.shape_noise
        self.motion_design += np.diag(T * noise[2 * n :])

    def sigma_along(self, normals: Floats) -> Floats:
        """Return the standard deviations, (N, n) [px], of nodes along the normals, (N, n, 2)."""
        u = 2 * np.arange(self.nodes.shape[1])
        x, y = normals[..., 0], normals[..., 1]
        variance = self.cov[:, u, u] * x * x + self.cov[:, u + 1, u + 1] * y * y
        variance += 2 * self.cov[:, u, u + 1] * x * y
        return np.asarray(np.sqrt(np.maximum(variance, 0.0)))

    def correct(
        self,
        offset: Floats,
        found: Bools,
        normals: Floats,
        T: float,
        config: ContourConfig,
        variance: float | None = None,
    ) -> None:
        """Update with edges, by the gain of the joint filter, or by those of (7) and then (8).

        The covariance is in Joseph form, which holds for any gain.

        :param offset: (N, n) offsets of the edges along the normals [px].
        :param found: (N, n) which lines have an edge.
        :param normals: (N, n, 2).
        :param T: time since the last frame [frames].
        :param variance: of an edge [px^2]; by default edge_variance.
        """
        count, n = self.nodes.shape[:2]
        R = np.where(found, variance or config.edge_variance, NO_EDGE_VARIANCE)
        PH = self._along_normals(self.cov, normals)
        if config.filters == 'two':
            K = self._gain_of_two_filters(found, normals, T, config)
        else:
            S = self._along_normals(PH[:, : 2 * n].swapaxes(1, 2), normals)
            S[:, np.arange(n), np.arange(n)] += R
            K = np.asarray(np.linalg.solve(S, PH.swapaxes(1, 2)).swapaxes(1, 2), float)
        step = (K @ np.where(found, offset, 0.0)[..., None])[..., 0]
        self.nodes += step[:, : 2 * n].reshape(count, n, 2)
        self.motion += step[:, 2 * n :]
        part = self.cov - K @ PH.swapaxes(1, 2)
        cov = part - self._along_normals(part, normals) @ K.swapaxes(1, 2)
        cov += (K * R[:, None]) @ K.swapaxes(1, 2)
        self.cov = (cov + cov.swapaxes(1, 2)) / 2

    @staticmethod
    def _along_normals(matrix: Floats, normals: Floats) -> Floats:
        """Return matrices, (N, m, 2n or more), projected on the lines, (N, m, n)."""
        n = normals.shape[1]
        pairs = matrix[:, :, : 2 * n].reshape(*matrix.shape[:2], n, 2)
        return np.asarray(
            pairs[..., 0] * normals[:, None, :, 0] + pairs[..., 1] * normals[:, None, :, 1]
        )

    def _gain_of_two_filters(
        self, found: Bools, normals: Floats, T: float, config: ContourConfig
    ) -> Floats:
        """Return the gain, (N, m, n), of the motion filter (7) followed by the shape filter (8).

        There an edge is a measured point, which implies that nothing moves along the contour.
        """
        count, n = self.nodes.shape[:2]
        v, H = config.edge_variance, T * motion_matrix(self.nodes)
        seen = np.repeat(found, 2, axis=1)[..., None] * H
        P = self.motion_design
        S = np.eye(MOTION_SIZE) + P @ (seen.swapaxes(1, 2) @ seen) / v
        self.motion_design = P = np.asarray(np.linalg.solve(S, P), float)
        each = np.zeros((count, 2 * n, n))  # a column of (Z - X') for each line
        i = np.arange(n)
        each[:, 2 * i, i], each[:, 2 * i + 1, i] = normals[..., 0], normals[..., 1]
        motion = P @ (seen.swapaxes(1, 2) @ each) / v
        k = np.where(found, self.node_design / (self.node_design + v), 0.0)
        self.node_design = self.node_design * (1 - k)
        moved = H @ motion
        shape = moved + np.repeat(k, 2, axis=1)[..., None] * (each - moved)
        return np.concatenate([shape, motion], axis=1)

    def hold_size(self, mask: Bools) -> None:
        """Stop scaling and rotation of unseen targets, mask (N,)."""
        self.motion[mask, 2:] = 0.0


def motion_matrix(nodes: Floats) -> Floats:
    """Return H of (6), with rotation, (N, 2n, MOTION_SIZE), for nodes (N, n, 2)."""
    arm = nodes - nodes.mean(axis=1, keepdims=True)
    H = np.zeros((*nodes.shape, MOTION_SIZE))
    H[..., 0, 0] = H[..., 1, 1] = 1.0
    H[..., 2] = arm
    H[..., 0, 3], H[..., 1, 3] = -arm[..., 1], arm[..., 0]
    return H.reshape(len(nodes), 2 * nodes.shape[1], MOTION_SIZE)


def motion_noise(config: ContourConfig) -> Floats:
    """Return the diagonal of Q of (7), (MOTION_SIZE,)."""
    turn = config.turn_noise if config.rotation else 0.0
    return np.array([config.motion_noise, config.motion_noise, config.scale_noise, turn])
