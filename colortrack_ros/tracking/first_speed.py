"""How fast a scene is, by its first two frames, before it is known which detection is whose."""

import math

import numpy as np
from scipy.spatial import cKDTree

from colortrack_ros.data import Floats

SHARES = np.geomspace(1e-3, 1.0, 25)
"""Candidates for the speed, as shares of the one assumed: eight a decade."""

LOG_SPREAD = math.log(10)
"""Standard deviation of the log of the speed. Assumed."""

SEEN_NEXT = 0.9
"""Probability that an object is detected again. Assumed."""

FAST = np.array([0.001, 0.05, 0.2])
"""Candidates for the share of objects as fast as assumed while the others are slower. Assumed."""

NEAR_QUANTILE, SIGMAS_APART = 0.25, 3.0
"""Quantile of the distances of neighbors, and how many standard deviations of their ways they are
apart if they are told apart. Assumed."""

ASSUMED_COUNT = 1.0
"""Weight of the speed assumed, in objects: they may move slowly now, and faster later. Assumed."""


def two_nearest(before: Floats, after: Floats) -> Floats:
    """Return the distances of the nearest two detections, (N, 2) [px], nearest first.

    :param before: (N, 2) positions in a frame [px].
    :param after: (M, 2) in the next one, at least two.
    """
    return np.asarray(cKDTree(after).query(before, k=2)[0])


def share_of_speed(near: Floats) -> float:
    """Return the root mean square of the ways of objects, over the one assumed.

    The next detection of an object that moves little is much nearer than the second nearest one.
    If those of others are a Poisson process of unknown density (prior 1 / density), the two
    distances have, but for a factor, the likelihood

        2 / r2^2 (1 - p + p exp(-r2^2 / 2 s^2)) + p / s^2 (exp(-r1^2 / 2 s^2) + exp(-r2^2 / 2 s^2))

    for a way that is normal with s on each axis: neither is the object's own, or one of them is.

    :param near: (N, 2) see two_nearest(), over the standard deviation of the way assumed, by axis.
    """
    near2 = np.maximum(near**2, 1e-12)
    s2 = (SHARES**2)[:, None, None]
    close = np.exp(-near2 / (2 * s2))  # by speed, object, neighbor
    own = SEEN_NEXT / s2[..., 0] * close.sum(axis=-1)
    many = FAST[:, None, None]
    fast, slow = many * own[-1], (1 - many) * own
    beyond = many * close[-1, :, 1] + (1 - many) * close[..., 1]
    likelihood = fast + slow + 2 / near2[:, 1] * (1 - SEEN_NEXT + SEEN_NEXT * beyond)
    log_posterior = np.log(likelihood).sum(axis=-1) - 0.5 * (np.log(SHARES) / LOG_SPREAD) ** 2
    weight = np.exp(log_posterior - log_posterior.max())
    moved, crept = ((own / likelihood).sum(axis=-1) for own in (fast, slow))
    moved += ASSUMED_COUNT
    square = (moved + crept * SHARES**2) / (moved + crept)
    return math.sqrt((weight * square).sum() / weight.sum())


def share_enough(near: Floats) -> float:
    """Return the way over the one assumed, at most 1, by which most neighbors are told apart.

    :param near: as of share_of_speed().
    """
    return min(float(np.quantile(near[:, 1], NEAR_QUANTILE)) / SIGMAS_APART, 1.0)
