"""Ego motion: the motion that all objects share is the camera's, and takes all tracks along."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from colortrack_ros.tracking.rectangles import DENSE

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

FEWEST = 5
"""Objects that have to agree: of few nobody can tell whose motion it is. Fitted by the labels of
juggled balls, whose gravity is no motion of the camera: 3, 4 and 5 cost 1.2, 0.6 and 0 points of
IDF1 beside ego_motion: none."""

VOTERS = 40
"""Objects that vote on a large shift, to bound the time: its share of the votes is within 8 %."""

REACH = 150.0
"""Longest shift from frame to frame that is looked for [px]: at 30 frames/s a camera that turns by
half a picture of 640 px in 70 ms."""

MOST = 0.8
"""Share of the objects, or of the detections, that have to agree that the camera stands, or nothing
else is looked for: 95 % are detected, and a few maneuver. Assumed."""

NEAR_SIGMAS = 3.0
"""A detection so near its prediction agrees, on both axes; 99.5 % of the right ones are."""

SIGNIFICANT = 9.2
"""By how much a shift, and turn and zoom beyond that, have to lower the negative log-likelihood, or
there is none: half of the quantile of chi-square with 2 degrees of freedom that a camera which
stands exceeds once in 10,000 frames."""

LEAST_SIGMA = 0.1
"""Of a detection beside its prediction [px]: of what stands still to the bit."""

MAD_TO_SIGMA = 1.4826
"""From the median of absolute deviations of a Gaussian to its standard deviation."""

SMALL_SAMPLE = 3.0
"""What a spread found in n pairs may be too small by, times 1 / sqrt(n): three standard deviations
of it (Rousseeuw and Croux 1993: it has an efficiency of 37 %, so 1.17)."""


class EgoMotion(NamedTuple):
    """x -> A x + shift, what the camera's motion since the last frame makes of a position.

    :param A: (2, 2), a turn and a zoom.
    :param shift: (2,) [px].
    :param variance: of where it takes an object, on each axis [px^2].
    """

    A: Floats
    shift: Floats
    variance: float = 0.0

    def of(self, x: Floats) -> Floats:
        """Where positions, (..., 2) [px], have come to."""
        return np.asarray(x @ self.A.T + self.shift)

    def take(self, x: Floats, _: object = None) -> 'EgoMotion':
        """What it does to tracks at x, (N, 2) [px], each with an A and a shift of its own."""
        count = len(x)
        A, shift = np.broadcast_to(self.A, (count, 2, 2)), np.broadcast_to(self.shift, (count, 2))
        return EgoMotion(A, shift, self.variance)

    def way(self, x: Floats, _: object = None) -> Floats:
        """How far positions, (..., 2) [px], have come, of where they are now."""
        return np.asarray(x - (x - self.shift) @ np.linalg.inv(self.A).T)

    def after(self, first: 'EgoMotion') -> 'EgoMotion':
        """Both, one after the other."""
        return EgoMotion(self.A @ first.A, self.of(first.shift), self.variance)

    def during(self, share: float) -> 'EgoMotion':
        """A share of it: of complex numbers, x -> a x + b is a turn about b / (1 - a)."""
        if self is STANDING:
            return self
        a, b = complex(*self.A[:, 0]), complex(*self.shift)
        part = a**share
        b *= share if abs(a - 1) < 1e-9 else (1 - part) / (1 - a)
        A = np.array([[part.real, -part.imag], [part.imag, part.real]])
        return EgoMotion(A, np.array([b.real, b.imag]))


STANDING = EgoMotion(np.eye(2), np.zeros(2))


def find_ego_motion(expected: Floats, variance: Floats, z: Floats) -> EgoMotion | None:
    """The motion that most objects share beyond what was predicted of each; None if there is none.

    :param expected: (N, 2) predictions of objects measured in the last frame [px].
    :param variance: (N, 2) of the predictions and of their measurements [px^2].
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
    if found is None:
        return None if motion is STANDING else motion
    return found.after(motion)


def _nearest(z: Floats, x: Floats) -> NDArray[np.intp]:
    """Which of the detections, (M, 2), is nearest to each of the positions x, (N, 2)."""
    if len(z) * len(x) > DENSE:
        return np.asarray(cKDTree(z).query(x)[1])
    u, v = z[:, 0] - x[:, :1], z[:, 1] - x[:, 1:]
    return np.asarray((u * u + v * v).argmin(axis=1))


def _agreeing(z: Floats, expected: Floats, sigma: Floats) -> tuple[Bools, NDArray[np.intp]]:
    """Which predictions, (N,), have a detection beside them, and which is nearest."""
    nearest = _nearest(z, expected)
    near = np.abs(z[nearest] - expected) <= NEAR_SIGMAS * sigma
    return near[:, 0] & near[:, 1], nearest


def _refined(z: Floats, expected: Floats, sigma: Floats, start: EgoMotion) -> EgoMotion:
    """A motion and what turn and zoom bring predictions nearer to their nearest detections.

    Iterated closest points (Besl and McKay 1992), of which those beyond a shrinking reach are left
    out: it begins with a third of the distance of neighbors, which are told apart then.
    """
    apart = cKDTree(expected).query(expected, 2)[0][:, 1]
    near, motion = NEAR_SIGMAS * float(np.median(sigma)), start
    for reach in (float(np.median(apart)) / 3, float(np.median(apart)) / 6, near):
        moved = motion.of(expected)
        nearest = _nearest(z, moved)
        close = np.hypot(*(z[nearest] - moved).T) <= max(reach, near)
        if np.count_nonzero(close) <= FEWEST:
            return start
        motion = _similarity(expected[close], z[nearest[close]])
    return motion


def _similarity(x: Floats, z: Floats) -> EgoMotion:
    """The turn, zoom and shift, by least squares, that take x to z, (K, 2) each."""
    middle, other = x.mean(axis=0), z.mean(axis=0)
    x, y = x - middle, z - other
    size = max(float((x**2).sum()), 1e-9)
    zoom = float((x * y).sum()) / size
    turn = float((x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]).sum()) / size
    A = np.array([[zoom, -turn], [turn, zoom]])
    return EgoMotion(A, other - A @ middle)


def _vote(z: Floats, expected: Floats, sigma: Floats) -> Floats:
    """The shift, (2,), that brings most predictions to a detection."""
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
    """Whether least squares find any shift, turn or zoom, of which half would be significant.

    :param x: (K, 2) positions, error: (K, 2) of them over sigma, (K, 2).
    """
    r = (x - x.mean(axis=0)) / sigma
    shift, size = error.sum(axis=0), max(float((r * r).sum()), 1e-9)
    zoom, turn = (r * error).sum(), (r[:, 0] * error[:, 1] - r[:, 1] * error[:, 0]).sum()
    gain = (shift @ shift / len(x) + (zoom * zoom + turn * turn) / size) / 2
    return bool(gain > SIGNIFICANT / 2 * min((error * error).mean(), 1.0))


def _fit(expected: Floats, z: Floats, sigma: Floats) -> EgoMotion | None:
    """The shift, or turn and zoom with it, of pairs that agree, (K, 2) each; None if it is none."""
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
    variance = 2 * float(np.median(sigma)) ** 2 / len(z)  # twice that of a mean: it turns as well
    return None if best is None else best._replace(variance=variance)
