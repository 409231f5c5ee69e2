"""Which track follows which object, and how wrong it is against what it says."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

ELLIPSE = 5.991
"""Squared Mahalanobis distance that holds 95 % (chi-square, 2)."""


@dataclass(frozen=True)
class Followed:
    """S times that a track was at an object, or coasted for one.

    frame, object, unseen: (S,), unseen the frames since it was last seen; track_id: (S,);
    error: (S, 4), cov: (S, 4, 4) of (u, v, du, dv).
    """

    frame: np.ndarray
    object: np.ndarray
    unseen: np.ndarray
    track_id: np.ndarray
    error: np.ndarray
    cov: np.ndarray

    def take(self, which):
        """Those of an index or mask."""
        return Followed(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    def inside(self, part):
        """Share within the 95 % ellipse of the position (0) or the velocity (2) [%]."""
        e, P = self.error[:, part : part + 2], self.cov[:, part : part + 2, part : part + 2]
        d2 = np.einsum('si,si->s', e, np.linalg.solve(P, e[..., None])[..., 0])
        return 100 * np.mean(d2 < ELLIPSE)

    def nees(self):
        """Mean squared error of (u, v, du, dv), normalized by what the track says of it."""
        weighted = np.linalg.solve(self.cov, self.error[..., None])[..., 0]
        return np.mean(np.sum(self.error * weighted, axis=1))

    def rmse(self, part):
        """Of the position (0) [px] or the velocity (2) [px/s]."""
        return np.sqrt(np.mean(np.sum(self.error[:, part : part + 2] ** 2, axis=1)))

    def area(self):
        """Median of the position ellipses, relative to a circle of 1 px."""
        return np.median(np.sqrt(np.linalg.det(self.cov[:, :2, :2])))

    def names(self):
        """IDs an object, on the average of the objects."""
        return np.mean([len(set(self.track_id[self.object == n])) for n in set(self.object)])


def known(world, mean, cov):
    """The same of a filter that knows who is who: mean (K, N, 4), cov (K, N, 4, 4)."""
    k, n = np.nonzero(world.exists)
    frame = np.arange(len(mean))[:, None]
    unseen = frame - np.maximum.accumulate(np.where(world.seen, frame, 0))
    error = mean - np.concatenate([world.position, world.velocity], -1)
    return Followed(k, n, unseen[k, n], n, error[k, n], cov[k, n])


def follow(world, frames, reach=40.0):
    """Pair objects with tracks: the nearest while seen, the same as before while not.

    :param reach: largest distance [px].
    """
    count = world.position.shape[1]
    owner, unseen, found = np.zeros(count, int), np.zeros(count, int), []
    for k, rows in enumerate(frames):
        seen = np.flatnonzero(world.seen[k])
        unseen = np.where(world.seen[k], 0, unseen + 1)
        at = np.stack([rows['u'], rows['v']], axis=1)
        distance = cdist(world.position[k, seen], at)
        i, j = linear_sum_assignment(np.minimum(distance, 2 * reach))
        near = distance[i, j] < reach
        owner[seen[i[near]]] = rows['track_id'][j[near]]
        pairs = [*zip(seen[i[near]], j[near], strict=True)]
        for n in np.flatnonzero(~world.seen[k] & world.exists[k]):
            pairs += [(n, j) for j in np.flatnonzero(rows['track_id'] == owner[n])]
        for n, j in pairs:
            row = rows[j]
            state = np.array([row['u'], row['v'], row['du'], row['dv']])
            error = state - np.concatenate([world.position[k, n], world.velocity[k, n]])
            found.append((k, n, unseen[n], row['track_id'], error, row['covariance']))
    return Followed(*(np.array(column) for column in zip(*found, strict=True)))


def kept(world, frames, settle=12, reach=40.0):
    """For every time that an object hid and came back: whether it has the ID of before.

    :param settle: frames that the tracker has for it after the return.
    """
    followed, same = follow(world, frames, reach), []
    back = ~world.seen[:-1] & world.seen[1:] & world.exists[:-1]
    for k, n in np.argwhere(back):
        mine = followed.take((followed.object == n) & (followed.unseen == 0))
        before = mine.track_id[mine.frame <= k]
        after = mine.track_id[(mine.frame > k) & (mine.frame <= k + settle)]
        if len(before):
            same.append(len(after) > 0 and after[-1] == before[-1])
    return np.array(same, bool)
