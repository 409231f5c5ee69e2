"""The textbook's constant velocity: a filter that knows noise and objects, and a tracker."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from worlds.world import RATE

DENSITY = 30.0**2
"""Of the white-noise acceleration for objects on straight lines [px^2/s^3]: what leaves its
velocities wrong by 7 to 11 px/s at a noise of 1 to 5 px."""

GATE = 13.8
"""Squared Mahalanobis distance that 0.1 % of the measurements exceed (chi-square, 2)."""


def transition(dt):
    """F (4, 4) of (u, v, du, dv)."""
    F = np.eye(4)
    F[0, 2] = F[1, 3] = dt
    return F


def process_noise(dt, density):
    """Q (4, 4) of continuous white-noise acceleration (Bar-Shalom 2001, 6.2.2)."""
    block = density * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
    return np.kron(block, np.eye(2))


def correct(mean, cov, z, R):
    """Batched update: mean (N, 4), cov (N, 4, 4), z (N, 2), R (2, 2)."""
    K = cov[:, :, :2] @ np.linalg.inv(cov[:, :2, :2] + R)
    mean = mean + (K @ (z - mean[:, :2])[..., None])[..., 0]
    return mean, cov - K @ cov[:, :2, :]


class Textbook:
    """Batched filters, gate, Hungarian method, three hits to confirm.

    :param memory: frames that a track lives unmeasured.
    """

    def __init__(self, sigma=1.0, density=1e4, speed=300.0, memory=10):
        self.F, self.Q = transition(1 / RATE), process_noise(1 / RATE, density)
        self.R, self.P = sigma**2 * np.eye(2), np.diag([sigma**2] * 2 + [speed**2] * 2)
        self.mean, self.cov = np.zeros((0, 4)), np.zeros((0, 4, 4))
        self.life, self.memory, self.next = np.zeros((0, 3), int), memory, 1

    def update(self, z):
        """Take centroids (M, 2), give rows (track_id, u, v)."""
        mean, cov = self.mean @ self.F.T, self.F @ self.cov @ self.F.T + self.Q
        S = cov[:, :2, :2] + self.R
        innovation = z - mean[:, None, :2]
        d2 = np.einsum('nmi,nij,nmj->nm', innovation, np.linalg.inv(S), innovation)
        cost = np.minimum(d2 + np.log(np.linalg.det(S))[:, None], 1e3)
        cost[d2 > GATE] = 1e4
        i, j = linear_sum_assignment(cost)
        near = d2[i, j] <= GATE
        i, j = i[near], j[near]
        mean[i], cov[i] = correct(mean[i], cov[i], z[j], self.R)
        self.life[:, 2] += 1
        self.life[i, 1] += 1
        self.life[i, 2] = 0
        keep = self.life[:, 2] <= np.where(self.life[:, 1] >= 3, self.memory, 1)
        new = z[np.isin(np.arange(len(z)), j, invert=True)]
        self.mean = np.concatenate([mean[keep], np.pad(new, ((0, 0), (0, 2)))])
        self.cov = np.concatenate([cov[keep], np.repeat(self.P[None], len(new), axis=0)])
        names = self.next + np.arange(len(new))
        born = np.stack([names, np.ones(len(new), int), np.zeros(len(new), int)], 1)
        self.life, self.next = np.concatenate([self.life[keep], born]), self.next + len(new)
        live = self.life[:, 1] >= 3
        return np.column_stack([self.life[live, 0], self.mean[live, :2]])


def matched(world, noise, density=DENSITY, speed=300.0):
    """The filter that knows which measurement is whose and how noisy they are.

    :return: mean (K, N, 4), cov (K, N, 4, 4).
    """
    F, Q, R = transition(1 / RATE), process_noise(1 / RATE, density), noise**2 * np.eye(2)
    count = world.z.shape[1]
    mean = np.hstack([world.z[0], np.zeros((count, 2))])
    cov = np.repeat(np.diag([noise**2] * 2 + [speed**2] * 2)[None], count, axis=0)
    means, covs = [mean], [cov]
    for z, seen in zip(world.z[1:], world.seen[1:], strict=True):
        mean, cov = mean @ F.T, F @ cov @ F.T + Q
        mean[seen], cov[seen] = correct(mean[seen], cov[seen], z[seen], R)
        means.append(mean.copy())
        covs.append(cov.copy())
    return np.array(means), np.array(covs)
