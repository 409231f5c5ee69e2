"""Update of the states of all objects, and of the errors of the cameras, at once.

Each object is updated as if the errors of the cameras were known (Friedland 1969). What is left of
its innovation that they explain, summed over the objects, corrects them; they correct the objects
in turn.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from colortrack_ros.world.conditional import conditional
from colortrack_ros.world.conditional import LINEAR_WITHIN
from colortrack_ros.world.conditional import LINEARIZATIONS
from colortrack_ros.world.conditional import Updated
from colortrack_ros.world.inverse_depth import in_inverse_depth
from colortrack_ros.world.inverse_depth import in_space
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import DEPTH
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.state import BIASES
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import MOVES
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import VELOCITY
from colortrack_ros.world.view import View

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.intp]

GATE = chdtri(np.arange(1, 6), 1e-4)
"""Of the normalized innovation squared, by the number of what is measured: one measurement in ten
thousand that is right is refused, one in a minute of 150 measurements a second."""


ERROR_MEMORY = 90.0
"""Time constant of the errors of the cameras [s]: a mount gives, a load shifts, light moves the
edges of blobs. By `python benchmark/world.py`, where they last: with 60 s fused ranges have a NEES
of 1.7 of 3 while the robot drives, with 120 s and more the ground has 3.8 and more."""


BEHIND_LENS = 0.02
"""What would be nearer to the camera [m] is behind its lens."""


def forget(errors: CameraErrors, dt: float) -> None:
    """Let the errors of the cameras be less certain after dt [s], in place."""
    errors.cov += (1 - np.exp(-2 * dt / ERROR_MEMORY)) * (errors.first - errors.cov)


def update(
    objects: Motions,
    errors: CameraErrors,
    measured: Measured,
    view: View,
    kinds: Kinds,
    ground: float,
    camera: int = 0,
    weigh: bool = True,
) -> tuple[Bools, Floats]:
    """Update states and errors by measurements, in place.

    :param objects: N, predicted; with G robots, as many of each, one robot after the other.
    :param measured: of each object; nothing used of those that are not measured.
    :param camera: which of them has measured.
    :param weigh: whether to tell how likely they were.
    :return: (N,) which measurements have been refused; (G,) the log of how likely all were, or 0.
    """
    number, front = measured.used.sum(axis=1), in_front(objects, view)
    refused = (number > 0) & ~front
    (rows,) = ((number > 0) & front).nonzero()
    if not len(rows):
        return refused, np.zeros(len(errors.mean))
    part = objects
    if len(rows) < len(objects):
        part, measured, kinds = objects.take(rows), measured.take(rows), kinds.take(rows)
    part = in_inverse_depth(part, view.optical)
    robot = rows // (len(objects) // len(errors.mean))
    limit = GATE[number[rows] - 1]
    states, right, change, likely = _jointly(
        part, errors, robot, measured, view, kinds, ground, camera, limit, weigh
    )
    refused[rows[~right]] = True
    if right.sum() < len(objects):
        each = np.repeat(change, len(objects) // len(change), axis=0)
        objects.whole = objects.shifted(each).whole
        states, rows = states.take(right), rows[right]
    objects.put(rows, in_space(states, view.optical))
    return refused, likely


def in_front(objects: Motions, view: View) -> Bools:
    """Which objects, (N,), are in front of the camera, by both hypotheses."""
    depth = (objects.mean[..., POSITION] - view.optical.t) @ view.optical.R[:, 2]
    return np.asarray((depth > BEHIND_LENS).all(axis=1))


def _jointly(
    part: Motions,
    errors: CameraErrors,
    robot: Indices,
    measured: Measured,
    view: View,
    kinds: Kinds,
    ground: float,
    camera: int,
    limit: Floats,
    weigh: bool,
) -> tuple[Motions, Bools, Floats, Floats]:
    """Update states in inverse depth, and the errors of the cameras in place.

    Where two ranges of one picture disagree and these change by much, it is linearized again at
    what they have become (Gauss-Newton): ground and size contradict each other by a pitch that is
    off by 2 degrees. By the ground alone that gains nothing.

    :param limit: (N,) of the normalized innovation squared.
    :return: the states, (N,) which measurements are right, how the errors have changed, and, if
        asked to weigh, the log of how likely the measurements were, (G,).
    """
    prior, change = errors.mean, np.zeros_like(errors.mean)
    step = conditional(part, errors, robot, measured, view, kinds, ground, camera)
    twice = measured.used[:, PLANE] & measured.used[:, [BLOB, DEPTH]].any(axis=1)
    right = np.asarray(step.nis <= limit)
    for last in range(LINEARIZATIONS):
        cov, further, told = _corrected(errors.cov, change, step, robot, right)
        change = change + further
        bent = (part.slope[twice] @ further[robot[twice], None, :, None])[..., POSITION, 0]
        if last == LINEARIZATIONS - 1 or not (np.abs(bent) > LINEAR_WITHIN).any():
            break
        there, moved = replace(errors, mean=prior + change), part.shifted(change[robot])
        step = conditional(moved, there, robot, measured, view, kinds, ground, camera)
    of = errors.cov, change, further, told, step, robot, right, limit
    likely = _likelihood(*of) if weigh else np.zeros(len(change))
    errors.mean, errors.cov = prior + change, cov
    return step.states.shifted(further[robot]), right, change, likely


def misfit(
    objects: Motions,
    errors: CameraErrors,
    measured: Measured,
    view: View,
    kinds: Kinds,
    ground: float,
    camera: int = 0,
) -> Floats:
    """How far measurements are from what is expected, (N,), squared, over the gate: 1 is its edge.

    :param objects: N, predicted, in front of the camera; measured: N, of each.
    """
    robot = np.zeros(len(objects), np.intp)
    part = in_inverse_depth(objects, view.optical)
    step = conditional(part, errors, robot, measured, view, kinds, ground, camera)
    return np.asarray(step.nis / GATE[measured.used.sum(axis=1) - 1])


def started(
    position: Floats,
    reach: Floats,
    measured: Measured,
    view: View,
    kinds: Kinds,
    errors: CameraErrors,
    ground: float,
    camera: int = 0,
) -> Motions:
    """States of objects that are seen for the first time; standing or moving, as far as they may.

    :param position: (N, 3) a guess, from which the first update begins [m].
    :param reach: (N,) standard deviation of the guess on each axis, so large that it does not
        count [m].
    """
    count, n = len(position), errors.mean.shape[1]
    sigma = np.zeros((count, 2, OF_OBJECT))
    sigma[..., POSITION] = reach[:, None, None]
    sigma[:, MOVES, VELOCITY] = kinds.speed
    sigma[..., BIASES] = kinds.sigma[:, None]
    objects = Motions.of(
        np.zeros((count, 2, OF_OBJECT)),
        np.zeros((count, 2, OF_OBJECT, n)),
        np.square(sigma)[..., None] * np.eye(OF_OBJECT),
        np.where(kinds.falls[:, None], [0.0, 1.0], 0.5),
    )
    objects.mean[..., POSITION] = position[:, None]
    part = in_inverse_depth(objects, view.optical)
    robot = np.arange(count) // max(count // len(errors.mean), 1)
    step = conditional(part, errors, robot, measured, view, kinds, ground, camera, within=0.0)
    return in_space(step.states, view.optical)


def _corrected(
    P: Floats, change: Floats, step: Updated, robot: Indices, right: Bools
) -> tuple[Floats, Floats, tuple[Floats, Floats]]:
    """The errors of the cameras after an update that has been linearized where they have changed.

    :param P: (G, 8 C, 8 C) covariance before it.
    :param change: (G, 8 C) of their mean, at which the step is linearized.
    :return: their covariance, by how much more they change, and what right measurements have told
        of them: the information, (G, 8 C, 8 C), and the vector, (G, 8 C), of Updated.
    """
    robot, count = robot[right], len(P)
    information = _summed(step.information[right], robot, count)
    vector = _summed(step.vector[right], robot, count)
    # (P^-1 + L)^-1 = (I + P L)^-1 P, for P that may be singular
    A = np.eye(vector.shape[1]) + P @ information
    off = P @ vector[..., None] - change[..., None]
    both = np.linalg.solve(A, np.concatenate([P, off], axis=-1))
    after, further = both[..., :-1], both[..., -1]
    cov = np.asarray((after + after.swapaxes(-1, -2)) / 2)
    return cov, np.asarray(further, float), (information, vector)


def _likelihood(
    P: Floats,
    change: Floats,
    further: Floats,
    told: tuple[Floats, Floats],
    step: Updated,
    robot: Indices,
    right: Bools,
    limit: Floats,
) -> Floats:
    """The log of how likely measurements were, (G,); as :func:`_corrected`.

    :param change: (G, 8 C) of the errors, with what they change by further.
    :param told: information and vector, as :func:`_corrected` gives them.
    """
    (information, vector), (each, volume) = told, step.likelihoods()
    at = change - further
    log = _summed(each[right], robot[right], len(P))
    # of a Gaussian in the errors, which is linearized away from its mean
    bent = (information @ at[..., None])[..., 0]
    A = np.eye(vector.shape[1]) + P @ information
    log -= (at * (vector + bent / 2)).sum(axis=1) + np.linalg.slogdet(A)[1] / 2
    log += ((vector + bent) * change).sum(axis=1) / 2
    # what is refused is as likely as what is just refused no longer
    return log + _summed((volume - limit / 2)[~right], robot[~right], len(P))


def _summed(each: Floats, robot: Indices, count: int) -> Floats:
    """The sums of values, (N, ...), over the objects of each of so many robots."""
    if count == 1:
        return np.asarray(each.sum(axis=0, keepdims=True))
    total = np.zeros((count, *each.shape[1:]))
    np.add.at(total, robot, each)
    return total
