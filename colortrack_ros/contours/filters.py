"""The filters of motion and shape, all targets at once.

The state of a target is its nodes X, (n, 2) [px], and its motion M = (u, v, s, r): velocity of the
center [px/frame], change of scale and angular velocity [1/frame]. With H of (6), a row for each
node (I, X - C, and X - C turned by a right angle)::

    X_k = X_{k-1} + T H M_k + w,  M_k = M_{k-1} + q,  z_i = n_i (X_i - X'_i) + v

(De Bem 2007, (4)-(8)), T being the time that has passed in frames, n_i the normal of line i and z_i
where its edge is. A line says nothing of what moves along the contour.

They are not those of the bank: its filters measure a position, (u, v), and go from frame to frame
by one matrix for all targets; here n scalars are measured along normals, and H is each target's.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.data import Columns

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.intp]

MOTION_SIZE = 4
"""Components of M."""

NO_EDGE_VARIANCE = 1e12
"""Variance of what has not been measured [px^2]: of 1e6 px, beyond any picture."""

NODE_SIGMA, MOTION_SIGMA = 2.0, np.array([1.0, 1.0, 1e-2, 1e-2])
"""Standard deviations of a new target: of a node [px], what a blur of 1.5 px and an opening by 1 px
to each side move an outline by, and of M [px/frame, 1/frame]. Mean squared errors of `silhouette`
and `approach`, 0.064 and 0.023 px^2, become 0.025 to 0.067 and 0.021 to 0.037 with half and twice
NODE_SIGMA, 0.029 to 0.064 and 0.022 to 0.024 with those of MOTION_SIGMA (``benchmark/contours.py
--constants filters.NODE_SIGMA filters.MOTION_SIGMA``)."""


@dataclass
class Contours(Columns):
    """N targets with n nodes each.

    :ivar nodes: (N, n, 2) [px].
    :ivar motion: (N, MOTION_SIZE).
    :ivar cov: (N, 2n + MOTION_SIZE, 2n + MOTION_SIZE) of nodes (u and v in turn) and motion.
    :ivar node_design: (N, n) P_X of (8) for each coordinate; of filters `two` alone.
    :ivar motion_design: (N, MOTION_SIZE, MOTION_SIZE) P_M of (7); of filters `two` alone.
    :ivar sides: (N, n, 2) usual intensities just inside and outside of each edge [levels], NaN
        where not known yet.
    """

    nodes: Floats
    motion: Floats
    cov: Floats
    node_design: Floats
    motion_design: Floats
    sides: Floats

    @classmethod
    def new(cls, nodes: Floats, velocity: Floats, config: ContourConfig) -> 'Contours':
        """Targets that begin with nodes (N, n, 2) and velocities (N, 2) [px/frame]."""
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
        """Take velocities for as good as unknown, with that standard deviation [px/frame]."""
        u = 2 * self.nodes.shape[1]
        self.cov[:, [u, u + 1], [u, u + 1]] = sigma**2
        self.motion_design[:, [0, 1], [0, 1]] = sigma**2

    def renewed(self, which: Indices, nodes: Floats, config: ContourConfig) -> 'Contours':
        """Some of these, which (K,), with new nodes (K, n, 2) and the motion that they have."""
        new, n = Contours.new(nodes, self.motion[which, :2], config), nodes.shape[1]
        new.motion[:] = self.motion[which]
        new.cov[:, 2 * n :, 2 * n :] = self.cov[which, 2 * n :, 2 * n :]
        new.motion_design[:] = self.motion_design[which]
        return new

    def predict(self, T: float, config: ContourConfig) -> None:
        """(4), with the covariance of nodes and motion together."""
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
        """Standard deviations of the nodes along the normals (N, n, 2), (N, n) [px]."""
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
        """Take edges in: by the gain of the one filter, or by those of (7) and then (8).

        The covariance is that of the estimate by whatever gain, in Joseph form.

        :param offset: (N, n) of the edges along the normals [px].
        :param found: (N, n); lines without an edge tell nothing.
        :param normals: (N, n, 2).
        :param T: time since the last frame [frames].
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
        """Matrices (N, m, 2n or more) times the normals, what lines see of the nodes, (N, m, n)."""
        n = normals.shape[1]
        pairs = matrix[:, :, : 2 * n].reshape(*matrix.shape[:2], n, 2)
        return np.asarray(
            pairs[..., 0] * normals[:, None, :, 0] + pairs[..., 1] * normals[:, None, :, 1]
        )

    def _gain_of_two_filters(
        self, found: Bools, normals: Floats, T: float, config: ContourConfig
    ) -> Floats:
        """What the motion filter (7) and then the shape filter (8) make of the edges, (N, m, n).

        Each edge is a measured point there: of what moves along the contour it is said that it
        does not.
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
        """Let targets that are not seen, mask (N,), neither grow nor turn."""
        self.motion[mask, 2:] = 0.0


def motion_matrix(nodes: Floats) -> Floats:
    """H of (6), with rotation: (N, 2n, MOTION_SIZE), what the motion does to nodes (N, n, 2)."""
    arm = nodes - nodes.mean(axis=1, keepdims=True)
    H = np.zeros((*nodes.shape, MOTION_SIZE))
    H[..., 0, 0] = H[..., 1, 1] = 1.0
    H[..., 2] = arm
    H[..., 0, 3], H[..., 1, 3] = -arm[..., 1], arm[..., 0]
    return H.reshape(len(nodes), 2 * nodes.shape[1], MOTION_SIZE)


def motion_noise(config: ContourConfig) -> Floats:
    """Q of (7), its diagonal (MOTION_SIZE,)."""
    turn = config.turn_noise if config.rotation else 0.0
    return np.array([config.motion_noise, config.motion_noise, config.scale_noise, turn])
