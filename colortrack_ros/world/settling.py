"""Standing or rolling slowly: before a robot that drives, they differ by the pitch of the camera.

What does not move as its kind is said to may have a slow velocity (`Kinds.slow`), beside which the
camera errors are learned. That it stands is one point of that distribution, zero; how much likelier
this point is than all others together follows from the densities there, before and after the
pictures (Dickey 1971). States of both together are those after a measurement of velocity zero, the
less certain the less likely it is that the object stands: published are these. What has to stand
is taken to from then on.
"""

from copy import copy

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.gaussian import mixture
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.belief import Belief
from colortrack_ros.world.cases import weighed
from colortrack_ros.world.conditional import summed
from colortrack_ros.world.state import ALONG_GROUND
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import STANDS
from colortrack_ros.world.whitening import whitening

STANDS_RATHER = 5.0
"""Odds, before any picture, that what seems to stand does so. With 16 and 1.5, balls with speeds of
0.1 m/s on each axis are in their 95 % ellipsoid in 91 and 97 % of the rows (with 5, 94; 60 runs,
seed 3), and what stands is 3.2 and 3.6 % of the range away in `benchmark/following.py` (3.3; 8
seeds)."""

SURELY_STANDS = 128.0
"""Odds from which on an object is taken to stand. With 48, what rests before a robot that drives is
1.8 instead of 1.7 % of the range away from 2 s on (`benchmark/world.py`), and so it is with 1e6."""

NEGLIGIBLE = 0.01
"""Probability below which it does not matter how slowly an object rolls. Chosen."""

MOST_LOG_ODDS = 50.0
"""Largest logarithm of the odds, either way: beyond it, nothing changes. Chosen."""


def published(belief: Belief, kinds: Kinds) -> Belief:
    """Return the belief in which what rather stands does so, and the rest is as uncertain.

    :param kinds: (N,) of its objects.
    """
    rows, _ = _doubtful(belief, kinds)
    if not len(rows):
        return belief
    cov, odds = _odds(belief, kinds, rows)
    return _stilled(belief, rows, cov / odds[:, None, None])


def settle(belief: Belief, kinds: Kinds, leaving: Bools | None = None) -> None:
    """Take what surely stands to do so from now on, in place, and what leaves as it is published.

    :param kinds: (N,) of its objects; `slow` becomes 0 where it is no longer needed.
    :param leaving: (N,) objects that will be forgotten; what they tell of the camera will not.
    """
    rows, stands = _doubtful(belief, kinds)
    if not len(rows):
        return
    cov, odds = _odds(belief, kinds, rows)
    sure = odds * stands > SURELY_STANDS
    now = sure if leaving is None else sure | leaving[rows]
    if not now.any():
        return
    R = np.where(sure, 0.0, 1 / odds)[:, None, None] * cov
    after = _stilled(belief, rows[now], R[now])
    belief.motion, belief.errors, belief.log_weight = after.motion, after.errors, after.log_weight
    kinds.slow[rows[now]] = 0.0


def _doubtful(belief: Belief, kinds: Kinds) -> tuple[Indices, Floats]:
    """Return the objects that may roll slowly, (K,), and the probabilities of `STANDS`, (K,)."""
    (rows,) = kinds.slow.nonzero()
    if not len(rows):
        return rows, np.zeros(0)
    p = belief.motion.probability[:, STANDS].reshape(len(belief.log_weight), -1)
    p = (belief.of_objects() * p).sum(axis=0)[rows]
    may = p > NEGLIGIBLE
    return rows[may], p[may]


def _odds(belief: Belief, kinds: Kinds, rows: Indices) -> tuple[Floats, Floats]:
    """Return the covariances of the slow velocities of objects, (K, 2, 2), and the odds of zero.

    :param rows: (K,) which objects.
    """
    errors, cases = belief.errors, len(belief.log_weight)
    at = _in_all_cases(belief, rows)
    slow = belief.motion.whole[at, STANDS, ALONG_GROUND]
    P, slope = errors.cov[errors.robots(at, len(belief.motion))], slow[..., OF_OBJECT:-1]
    each = slow[..., ALONG_GROUND] + slope @ P @ slope.swapaxes(-1, -2)
    weight = belief.of_objects()[:, rows]
    v, cov = mixture(weight, slow[..., -1].reshape(cases, -1, 2), each.reshape(cases, -1, 2, 2))
    W, volume = whitening(cov)
    log = np.log(STANDS_RATHER * np.square(kinds.slow[rows])) + volume
    log -= np.square(W @ v[..., None])[..., 0].sum(axis=1) / 2
    return cov, np.exp(np.clip(log, -MOST_LOG_ODDS, MOST_LOG_ODDS))


def _stilled(belief: Belief, rows: Indices, R: Floats) -> Belief:
    """Return the belief after velocities of zero were measured.

    :param rows: (K,) of which objects; R: (K, 2, 2) covariances of the measurements.
    """
    errors, cases = belief.errors, len(belief.log_weight)
    at, motion = _in_all_cases(belief, rows), belief.motion
    stands, p = motion.whole[at, STANDS], motion.probability[at, STANDS]
    velocity, of = stands[:, ALONG_GROUND], errors.robots(at, len(motion))
    S = velocity[..., ALONG_GROUND].reshape(cases, -1, 2, 2) + R
    W, _ = whitening(S.reshape(-1, 2, 2))
    white = W @ velocity
    share = p * _shown(white, stands, errors.cov[of], belief.eye)
    motion = Motions(motion.whole.copy(), motion.probability)
    motion.whole[at, STANDS] = stands - white[..., :OF_OBJECT].swapaxes(-1, -2) @ white
    cov, change, _ = _learned(errors.cov, white, share, of)
    stilled = copy(belief)
    stilled.motion = motion.shifted(np.repeat(change, len(motion) // len(change), axis=0))
    stilled.errors = CameraErrors(errors.mean + change, cov, errors.first)
    if cases > 1:
        # as in `Updated.likelihoods`: slow velocities are in meters
        white = np.tile(whitening(S.mean(axis=0))[0], (cases, 1, 1)) @ velocity
        share = np.tile(share.reshape(cases, -1).mean(axis=0), cases)
        log = _learned(errors.cov, white, share, of)[-1]
        stilled.log_weight = weighed(belief.log_weight, log)
    return stilled


def _shown(white: Floats, states: Floats, P: Floats, eye: Floats) -> Floats:
    """Return the share of what camera errors make of velocities that is not of their noise, (K,).

    In pixels, the noise of velocities is the same wherever an object is. In meters, along the ray,
    it grows with the square of the range. So an error that makes the range longer by a share makes
    a velocity that is noise larger by twice that share, though the robot stands and nothing shows
    the error. With all of it counted, what rests before a robot that stands has a NEES of 3.6 in
    place of 3.2, of 3 (`benchmark/world.py`, mean of seeds 101 to 104). As with `LEAST_PARALLAX`,
    smaller effects do not count.

    :param white: (K, 2, 8 + 8 C + 1) velocities, whitened: their noise is 1 on each axis or less.
    :param states: (K, 8, 8 + 8 C + 1); P: (K, 8 C, 8 C) covariance of the camera errors.
    :param eye: (3,) position of the camera [m].
    """
    arm, slope = states[:, POSITION, -1] - eye, white[..., OF_OBJECT:-1]
    longer = arm[:, None] @ states[:, POSITION, OF_OBJECT:-1]
    longer /= np.square(arm).sum(axis=1)[:, None, None]
    told = ((slope @ P) * slope).sum(axis=(1, 2))
    noise = white.shape[1] * 4 * ((longer @ P) * longer).sum(axis=(1, 2))
    return np.asarray(np.maximum(0.0, 1 - noise / np.maximum(told, TINY)))


def _learned(P: Floats, white: Floats, share: Floats, of: Indices) -> tuple[Floats, Floats, Floats]:
    """Return what velocities of zero tell of the camera errors of each robot.

    :param P: (G, 8 C, 8 C) their covariance; of: (K,) whose robot's objects these are.
    :param white: (K, 2, 8 + 8 C + 1) rows of states, whitened; share: (K,) of it that counts.
    :return: the covariance after them, the change of the mean, (G, 8 C), and their log likelihood
        but for what is the same for all cases, (G,).
    """
    white = white[..., OF_OBJECT:]
    told = summed(share[:, None, None] * (white.swapaxes(-1, -2) @ white), of, len(P))
    information, vector = told[:, :-1, :-1], -told[:, :-1, -1]
    A = np.eye(vector.shape[1]) + P @ information
    both = np.linalg.solve(A, np.concatenate([P, P @ vector[..., None]], axis=-1))
    after, change = both[..., :-1], both[..., -1]
    log = (vector * change).sum(axis=1) - told[:, -1, -1] - np.linalg.slogdet(A)[1]
    return (after + after.swapaxes(-1, -2)) / 2, change, log / 2


def _in_all_cases(belief: Belief, rows: Indices) -> Indices:
    """Return the rows of objects, (C K,), in all cases."""
    return np.asarray((len(belief) * np.arange(len(belief.log_weight))[:, None] + rows).ravel())
