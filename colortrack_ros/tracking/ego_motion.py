"""Ego motion: the motion that all objects share is the camera's, and takes all tracks along."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

FEWEST = 3
"""Objects that have to agree: of one or two nobody can tell whose motion it is."""

VOTERS = 40
"""Objects that vote on a large shift, to bound the time: its share of the votes is within 8 %."""

REACH = 150.0
"""Longest shift from frame to frame that is looked for [px]: at 30 frames/s a camera that turns by
half a picture of 640 px in 70 ms."""

NEAR_SIGMAS = 3.0
"""A detection so near its prediction agrees, on both axes; 99.5 % of the right ones are."""

SIGNIFICANT = 4.0
"""Standard deviations of its own error by which a shift, turn or zoom has to differ from none, or
it is none: one frame in 16,000 of a camera that stands."""

CARRIED = 0.05
"""Share of the shift that goes over into the velocities, which follow a steady motion of the camera
within 20 frames: they are published against the picture. Assumed."""


class EgoMotion(NamedTuple):
    """x -> A x + shift, what the camera's motion since the last frame makes of a position.

    :param A: (2, 2), a turn and a zoom.
    :param shift: (2,) [px].
    """

    A: Floats
    shift: Floats


def find_ego_motion(expected: Floats, variance: Floats, z: Floats) -> EgoMotion | None:
    """The motion that most objects share beyond what was predicted of each; None if there is none.

    :param expected: (N, 2) predictions of objects measured in the last frame [px].
    :param variance: (N, 2) of the predictions and of their measurements [px^2].
    :param z: (M, 2) detections [px].
    """
    if min(len(expected), len(z)) < FEWEST:
        return None
    tree, sigma = cKDTree(z), np.sqrt(variance)
    shift = np.zeros(2)
    agrees, nearest = _agreeing(tree, expected, sigma)
    if not agrees.all():  # in a crowd many have somebody else's detection beside them
        voted = _vote(tree, expected, sigma)
        others, their_nearest = _agreeing(tree, expected + voted, sigma)
        if others.sum() >= max(FEWEST, len(expected) / 2, agrees.sum() + 2):
            shift, agrees, nearest = voted, others, their_nearest
    if agrees.sum() < max(FEWEST, len(expected) / 2):
        return None
    return _fit(expected[agrees], z[nearest[agrees]], sigma[agrees], shift)


def _agreeing(tree: cKDTree, expected: Floats, sigma: Floats) -> tuple[Bools, NDArray[np.intp]]:
    """Which predictions, (N,), have a detection beside them, and which is nearest."""
    _, nearest = tree.query(expected)
    error = np.abs(tree.data[nearest] - expected)
    return (error <= NEAR_SIGMAS * sigma).all(axis=1), nearest


def _vote(tree: cKDTree, expected: Floats, sigma: Floats) -> Floats:
    """The shift, (2,), that brings most predictions to a detection."""
    some = np.linspace(0, len(expected) - 1, min(len(expected), VOTERS)).astype(int)
    lists = tree.query_ball_point(expected[some], REACH)
    who = np.repeat(some, [len(one) for one in lists])
    if not len(who):
        return np.zeros(2)
    which = np.concatenate([np.array(one, int) for one in lists])
    shifts = tree.data[which] - expected[who]
    votes = cKDTree(shifts)
    reach = float(np.median(sigma[who])) * NEAR_SIGMAS
    best = votes.query_ball_point(shifts, reach, return_length=True).argmax()
    return np.median(shifts[votes.query_ball_point(shifts[best], reach)], axis=0)


def _fit(expected: Floats, z: Floats, sigma: Floats, start: Floats) -> EgoMotion | None:
    """Shift, then turn and zoom, of pairs that agree, (K, 2) each; what is significant of them."""
    error = z - expected
    shift = np.median(error, axis=0)
    spread = np.median(np.abs(error - shift)) * 1.4826  # of a Gaussian: its standard deviation
    spread = max(float(spread), 1e-3)
    doubt = 1.2533 * spread / np.sqrt(len(z))  # of the median of a Gaussian
    moved = start.any() or bool((np.abs(shift) > SIGNIFICANT * doubt).any())
    if len(z) > FEWEST:
        middle, other = expected.mean(axis=0), z.mean(axis=0)
        x, y = expected - middle, z - other
        size = max(float((x**2).sum()), 1e-9)
        zoom = float((x * y).sum()) / size
        turn = float((x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]).sum()) / size
        if np.hypot(zoom - 1, turn) > SIGNIFICANT * spread / np.sqrt(size):
            A = np.array([[zoom, -turn], [turn, zoom]])
            return EgoMotion(A, other - A @ middle)
    return EgoMotion(np.eye(2), shift) if moved else None
