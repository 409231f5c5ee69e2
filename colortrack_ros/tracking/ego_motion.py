"""Ego motion: motion shared by all objects is the camera's, and carries all tracks along."""

from collections.abc import Sized
import math
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree
from scipy.special import fdtrc

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.tracking.rectangles import nearest_points

FEWEST = 5
"""Least number of objects that must agree: with only a few, the motion may be their own. Fitted on
labels of juggled balls, whose common gravity is no camera motion: 3, 4 and 5 cost 1.2, 0.6 and 0
points of IDF1 compared with ego_motion: none."""

VOTERS = 40
"""Objects that vote on a large shift, to bound the time: the share of votes for it has a standard
error of 8 %."""

REACH = 150.0
"""Longest shift searched from frame to frame [px]: that of a camera at 30 frames/s that turns by
half a picture of 640 px in 70 ms."""

MOST = 0.8
"""Share of the objects, or of the detections if fewer, that must agree with a camera that has not
moved to end the search, and of the objects with the motion of one that stood: 95 % are detected,
and a few maneuver. Assumed."""

NEAR_SIGMAS = 3.0
"""Largest distance, on each axis, of a detection that agrees with a prediction; 99.5 % of the
correct ones are within it."""

SIGNIFICANT = 9.2
"""Least decrease of the negative log-likelihood by a shift, and again by adding turn and zoom, at
which they are accepted: half the quantile of chi-square with 2 degrees of freedom that a standing
camera exceeds once in 10,000 frames."""

JUMP_CHANCE, MOTION_NUMBERS = 1e-4, 4
"""Probability by chance below which the motion of a camera that stood is evident, as with
SIGNIFICANT, and how many numbers a turn, zoom and shift are."""

MOST_ZOOM = 2.0
"""Greatest zoom from frame to frame, in or out. Assumed. Objects within their noise of one point,
or detections at one, zoom to nothing or to anything, and tell nothing but the shift. Nor does a
zoom whose stamps make it faster than that tell what the camera does until the next frame."""

LEAST_SIGMA = 0.1
"""Least standard deviation of a detection about its prediction [px], for scenes that are exactly
static."""

MAD_TO_SIGMA = 1.4826
"""Ratio of the standard deviation of a Gaussian to its median absolute deviation."""

SMALL_SAMPLE = 3.0
"""Relative amount by which a spread estimated from n pairs may be too small, times sqrt(n): three
of its standard deviations (Rousseeuw and Croux 1993: it has an efficiency of 37 %, hence 1.17)."""


class EgoMotion(NamedTuple):
    """x -> A x + shift: how the camera's motion since the last frame moves a position.

    :param A: (2, 2) turn and zoom.
    :param shift: (2,) [px].
    :param variance: of a moved position, on each axis [px^2].
    """

    A: Floats
    shift: Floats
    variance: float = 0.0

    def of(self, x: Floats) -> Floats:
        """Return where positions x, (..., 2) [px], have moved."""
        return np.asarray(x @ self.A.T + self.shift)

    def take(self, tracks: Sized) -> 'EgoMotion':
        """Return the motion of tracks, with an A and a shift for each."""
        count = len(tracks)
        A, shift = np.broadcast_to(self.A, (count, 2, 2)), np.broadcast_to(self.shift, (count, 2))
        return EgoMotion(A, shift, self.variance)

    def way(self, x: Floats, _: object = None) -> Floats:
        """Return the displacements that led to the present positions x, (..., 2) [px]."""
        return np.asarray(x - (x - self.shift) @ np.linalg.inv(self.A).T)

    def after(self, first: 'EgoMotion') -> 'EgoMotion':
        """Return the motion first, followed by this one."""
        return EgoMotion(self.A @ first.A, self.of(first.shift), self.variance)

    def during(self, share: float) -> 'EgoMotion':
        """Return a share of the motion.

        In complex numbers, x -> a x + b is a turn and a zoom about b / (1 - a).

        :return: none, if it would zoom by more than MOST_ZOOM: of two frames that came within a
            nanosecond, by their stamps, no motion lasts until the next one.
        """
        if self is STANDING:
            return self
        a, b = complex(*self.A[:, 0]), complex(*self.shift)
        if abs(share * math.log(abs(a))) > math.log(MOST_ZOOM):
            return STANDING
        part = a**share
        b *= share if abs(a - 1) < 1e-9 else (1 - part) / (1 - a)
        A = np.array([[part.real, -part.imag], [part.imag, part.real]])
        return EgoMotion(A, np.array([b.real, b.imag]))


STANDING = EgoMotion(np.eye(2), np.zeros(2))


def find_ego_motion(expected: Floats, variance: Floats, z: Floats) -> EgoMotion | None:
    """Return the motion that most objects share beyond their predictions; None if there is none.

    :param expected: (N, 2) predictions of objects measured in the last frame [px].
    :param variance: (N, 2) of the predictions plus the measurements [px^2].
    :param z: (M, 2) detections [px].
    """
    if min(len(expected), len(z)) < FEWEST:
        return None
    sigma, motion = np.sqrt(variance), STANDING
    agrees, nearest = _agreeing(z, expected, sigma)
    if np.count_nonzero(agrees) < MOST * min(len(expected), len(z)):
        for start in (STANDING, EgoMotion(STANDING.A, _vote(z, expected, sigma))):
            other = _refined(z, expected, sigma, start)
            others, their_nearest = _agreeing(z, other.of(expected), sigma)
            if others.sum() >= max(FEWEST, len(expected) / 2, agrees.sum() + 2):
                motion, agrees, nearest = other, others, their_nearest
    if agrees.sum() < max(FEWEST, len(expected) / 2):
        return None
    found = _fit(motion.of(expected)[agrees], z[nearest[agrees]], sigma[agrees])
    if found is not None:
        return found.after(motion)
    return None if motion is STANDING else motion._replace(variance=_variance(sigma[agrees]))


def find_jump(expected: Floats, variance: Floats, z: Floats) -> EgoMotion | None:
    """Return the motion of a camera that stood, None unless it is evident.

    It is if less than half of the objects are found where they are expected, and MOST with the
    motion, each by a detection of its own.

    :param expected, variance, z: as those of find_ego_motion().
    """
    if len(expected) < FEWEST or 2 * count_found(expected, variance, z) >= len(expected):
        return None
    motion = find_ego_motion(expected, variance, z)
    if motion is None:
        return None
    moved = motion.of(expected)
    agrees, nearest = _agreeing(z, moved, np.sqrt(variance))
    if len(np.unique(nearest[agrees])) < MOST * len(expected):
        return None
    still = z[nearest_points(z, expected)] - expected
    chance = _chance(still[agrees], (z[nearest] - moved)[agrees])
    return motion if chance < JUMP_CHANCE else None


def _chance(still: Floats, moved: Floats) -> float:
    """Return how often noise of any level is that much less by a turn, zoom and shift (F-test).

    What is known of the noise of detections may be far off in the first frames.

    :param still, moved: (K, 2) errors of objects without and with the motion [px].
    """
    left = moved.size - MOTION_NUMBERS
    least = float((moved * moved).sum()) + moved.size * LEAST_SIGMA**2
    gain = max(float((still * still).sum()) - least, 0.0)
    return float(fdtrc(MOTION_NUMBERS, left, gain / MOTION_NUMBERS / (least / left)))


def count_found(expected: Floats, variance: Floats, z: Floats) -> int:
    """Return how many objects have a detection where they are expected.

    :param expected, variance, z: as those of find_ego_motion().
    """
    return int(np.count_nonzero(_agreeing(z, expected, np.sqrt(variance))[0]))


def _agreeing(z: Floats, expected: Floats, sigma: Floats) -> tuple[Bools, Indices]:
    """Return which predictions, (N,), have a detection close by, and the index of the nearest."""
    nearest = nearest_points(z, expected)
    near = np.abs(z[nearest] - expected) <= NEAR_SIGMAS * sigma
    return near[:, 0] & near[:, 1], nearest


def _refined(z: Floats, expected: Floats, sigma: Floats, start: EgoMotion) -> EgoMotion:
    """Refine a motion by the turn and zoom that align predictions with their nearest detections.

    Iterated closest points (Besl and McKay 1992), without pairs beyond a shrinking radius. It
    starts at a third of the distance between neighbors, which rules out mix-ups.
    """
    apart = cKDTree(expected).query(expected, 2)[0][:, 1]
    near, motion = NEAR_SIGMAS * float(np.median(sigma)), start
    for reach in (float(np.median(apart)) / 3, float(np.median(apart)) / 6, near):
        moved = motion.of(expected)
        nearest = nearest_points(z, moved)
        close = np.hypot(*(z[nearest] - moved).T) <= max(reach, near)
        if np.count_nonzero(close) <= FEWEST:
            return start
        motion = _similarity(expected[close], z[nearest[close]])
    return motion


def _similarity(x: Floats, z: Floats) -> EgoMotion:
    """Return the turn, zoom and shift that take x to z, (K, 2) each, by least squares."""
    middle, other = x.mean(axis=0), z.mean(axis=0)
    x, y = x - middle, z - other
    size = max(float((x**2).sum()), 1e-9)
    zoom = float((x * y).sum()) / size
    turn = float((x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]).sum()) / size
    told = 1 / MOST_ZOOM <= np.hypot(zoom, turn) <= MOST_ZOOM
    A = np.array([[zoom, -turn], [turn, zoom]]) if told else STANDING.A
    return EgoMotion(A, other - A @ middle)


def _vote(z: Floats, expected: Floats, sigma: Floats) -> Floats:
    """Return the shift, (2,), that brings the most predictions to a detection."""
    some = np.linspace(0, len(expected) - 1, min(len(expected), VOTERS)).astype(int)
    lists = cKDTree(z).query_ball_point(expected[some], REACH)
    who = np.repeat(some, [len(one) for one in lists])
    if not len(who):
        return np.zeros(2)
    which = np.concatenate([np.array(one, int) for one in lists])
    shifts = z[which] - expected[who]
    votes = cKDTree(shifts)
    reach = float(np.median(sigma[who])) * NEAR_SIGMAS
    best = votes.query_ball_point(shifts, reach, return_length=True).argmax()
    return np.median(shifts[votes.query_ball_point(shifts[best], reach)], axis=0)


def _may_be(x: Floats, error: Floats, sigma: Floats) -> bool:
    """Return whether a least-squares shift, turn or zoom gains half of what is significant.

    :param x: (K, 2) positions, error: (K, 2) of them over sigma, (K, 2).
    """
    r = (x - x.mean(axis=0)) / sigma
    shift, size = error.sum(axis=0), max(float((r * r).sum()), 1e-9)
    zoom, turn = (r * error).sum(), (r[:, 0] * error[:, 1] - r[:, 1] * error[:, 0]).sum()
    gain = (shift @ shift / len(x) + (zoom * zoom + turn * turn) / size) / 2
    return bool(gain > SIGNIFICANT / 2 * min((error * error).mean(), 1.0))


def _fit(expected: Floats, z: Floats, sigma: Floats) -> EgoMotion | None:
    """Fit a shift, or turn, zoom and shift, to agreeing pairs, (K, 2) each.

    Returns None if none of them is significant.
    """
    if not _may_be(expected, (z - expected) / sigma, sigma):
        return None
    candidates = [EgoMotion(STANDING.A, np.median(z - expected, axis=0))]
    if len(z) > FEWEST:
        candidates.append(_similarity(expected, z))
    error = (z - candidates[-1].of(expected)) / sigma
    spread = float(np.median(np.abs(error - np.median(error, axis=0)))) * MAD_TO_SIGMA
    sigma = sigma * min(spread * (1 + SMALL_SAMPLE / np.sqrt(len(z))), 1.0)
    sigma = np.maximum(sigma, LEAST_SIGMA)

    def cost(motion: EgoMotion) -> float:
        d2 = (((z - motion.of(expected)) / sigma) ** 2).sum(axis=1)
        return float(np.minimum(d2, NEAR_SIGMAS**2).sum()) / 2

    best, least = None, cost(STANDING)
    for motion in candidates:
        now = cost(motion)
        if now < least - SIGNIFICANT:
            best, least = motion, now
    return None if best is None else best._replace(variance=_variance(sigma))


def _variance(sigma: Floats) -> float:
    """Return that of a motion fitted to K pairs, (K, 2), twice that of a mean, for the turn."""
    return 2 * float(np.median(sigma)) ** 2 / len(sigma)
