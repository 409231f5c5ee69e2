"""Joint update of the states of all objects and the errors of the cameras.

Each object is updated as if the camera errors were known (Friedland 1969). The part of its
innovation that camera errors explain, summed over all objects, corrects these errors, which in turn
correct the objects.
"""

from dataclasses import replace

import numpy as np
from scipy.special import chdtri

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.world.conditional import conditional
from colortrack_ros.world.conditional import LINEAR_WITHIN
from colortrack_ros.world.conditional import LINEARIZATIONS
from colortrack_ros.world.conditional import summed
from colortrack_ros.world.conditional import Updated
from colortrack_ros.world.contact import keep_on_ground
from colortrack_ros.world.inverse_depth import in_inverse_depth
from colortrack_ros.world.inverse_depth import in_space
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import two_ranges
from colortrack_ros.world.state import ALONG_GROUND
from colortrack_ros.world.state import BIASES
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import MOVES
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import STANDS
from colortrack_ros.world.state import VELOCITY
from colortrack_ros.world.view import View

REFUSED = 1e-4
"""Share of right measurements that the gate refuses: one in ten thousand, or about one a minute at
150 measurements a second."""

GATE = chdtri(np.arange(1, 6), REFUSED)
"""Gate of the normalized innovation squared, by the number of measured values."""

ERROR_MEMORY = 3600.0
"""Time constant of the camera errors [s]: mounts give, loads shift, and light moves the edges of
blobs. Assumed: within an hour. What stands before a robot that drives, whose errors really change
within 1000 s, has NEES of 2.8 to 3.4 of 3; within 300 s 4.5 to 5.7."""


BEHIND_LENS = 0.02
"""Least distance from the camera [m]; what is nearer is behind its lens. Assumed: the length of a
small lens."""


def forget(objects: Motions, errors: CameraErrors, dt: float) -> None:
    """Let the camera errors change for dt [s], in place.

    Objects do not move with them: their means and whole covariances stay, and only the part that
    the errors explain becomes smaller. Kept as it was, things would seem to follow the camera.
    """
    change = 1 - np.exp(-2 * dt / ERROR_MEMORY)
    if change <= 0:
        return
    unit, slope = errors.unit, objects.slope
    scale, count = unit[:, None] * unit, len(unit)
    before = errors.cov / scale
    errors.cov += change * (errors.first - errors.cov)
    # regression of the errors before on those after, and the covariance that this leaves
    after = (1 - change) * before
    after.reshape(len(after), -1)[:, :: count + 1] += change
    by = np.linalg.solve(after, before).swapaxes(-1, -2)
    left = (before - by @ before) * scale
    both = np.concatenate([left, by * (unit[:, None] / unit)], axis=-1)
    both = (slope.reshape(len(before), -1, count) @ both).reshape(*slope.shape[:-1], 2 * count)
    objects.cov[...] += both[..., :count] @ slope.swapaxes(-1, -2)
    slope[...] = both[..., count:]


def update(
    objects: Motions,
    errors: CameraErrors,
    measured: Measured,
    view: View,
    kinds: Kinds,
    ground: float,
    camera: int = 0,
    cases: int = 1,
) -> tuple[Bools, Floats]:
    """Update states and camera errors by measurements, in place.

    :param objects: N, predicted; with G robots, the same number for each, grouped by robot.
    :param measured: of each object; nothing is used of unmeasured ones.
    :param camera: index of the measuring camera; cases: how many the objects are grouped by.
    :return: (N,) which were refused; (G,) the log likelihood of all of them, 0 if no other case is.
    """
    number, front = measured.used.sum(axis=1), in_front(objects, view)
    refused = (number > 0) & ~front
    rows, part = np.flatnonzero((number > 0) & front), objects
    if not len(rows):
        return refused, np.zeros(len(errors.mean))
    if len(rows) < len(objects):
        part, measured, kinds = objects.take(rows), measured.take(rows), kinds.take(rows)
    part = in_inverse_depth(part, view.optical)
    robot = errors.robots(rows, len(objects))
    limit, of = GATE[number[rows] - 1], rows % (len(objects) // cases) if cases > 1 else None
    states, right, change, likely = _jointly(
        part, errors, robot, measured, view, kinds, ground, camera, limit, of
    )
    there, is_possible = _placed(states, measured, view, kinds, ground)
    right &= is_possible
    refused[rows[~right]] = True
    if np.count_nonzero(right) == len(objects):
        objects.whole, objects.probability = there.whole, there.probability
    else:
        objects.whole = objects.shifted(change.repeat(len(objects) // len(change), axis=0)).whole
        objects.put(rows[right], there.take(right))
    return refused, likely


def _placed(
    states: Motions, measured: Measured, view: View, kinds: Kinds, ground: float
) -> tuple[Motions, Bools]:
    """Return states in space, kept on the ground, and which, (N,), are not above the horizon."""
    there = in_space(states, view.optical)
    keep_on_ground(there, measured, view.optical, kinds, ground)
    return there, in_front(there, view) if view.parks else np.ones(len(there), bool)


def doubt(objects: Motions, refused: Bools) -> None:
    """Weigh the hypotheses of falling objects whose measurements were refused, (N,), in place.

    REFUSED of these would be of what flies on: more often, they were thrown harder than expected.
    What was taken for thrown before flies on as that, and may have been thrown once more: bounces
    make a throw a narrow Gaussian, beyond which those straight up are soon.
    """
    again = refused & (objects.probability[:, STANDS] > 1 / 2)
    objects.whole[again, MOVES] = objects.whole[again, STANDS]
    p = objects.probability[refused] * [1.0, REFUSED]
    objects.probability[refused] = p / p.sum(axis=1, keepdims=True)
    objects.probability[again] = [0.0, 1.0]


def in_front(objects: Motions, view: View) -> Bools:
    """Return which objects, (N,), are in front of the camera under both hypotheses."""
    depth = (objects.mean[..., POSITION] - view.optical.t) @ view.optical.R[:, 2]
    front = depth > BEHIND_LENS
    return np.asarray(front[:, STANDS] & front[:, MOVES])


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
    of: Indices | None,
) -> tuple[Motions, Bools, Floats, Floats]:
    """Update states in inverse depth, and the camera errors in place.

    If two ranges of one picture disagree and this changes the errors by much, linearize again at
    the new estimate (Gauss-Newton): ground and size contradict each other if the pitch is off by 2
    degrees. With the ground alone, that gains nothing.

    :param limit: (N,) gate of the normalized innovation squared.
    :param of: (N,) which object each is, if cases are compared.
    :return: the states, (N,) which measurements passed the gate, the change of the camera errors,
        and, if of is given, the log likelihood of the measurements, (G,).
    """
    prior, change = errors.mean, np.zeros_like(errors.mean)
    step = conditional(part, errors, robot, measured, view, kinds, ground, camera)
    right, twice = np.asarray(step.nis <= limit), two_ranges(measured)
    for last in range(LINEARIZATIONS):
        cov, further, told = _corrected(errors.cov, change, step, robot, right)
        change = change + further
        bent = (part.slope[twice] @ further[robot[twice], None, :, None])[..., POSITION, 0]
        if last == LINEARIZATIONS - 1 or not np.count_nonzero(np.abs(bent) > LINEAR_WITHIN):
            break
        there, moved = replace(errors, mean=prior + change), part.shifted(change[robot])
        step = conditional(moved, there, robot, measured, view, kinds, ground, camera)
    each = errors.cov, change, further, told, step, robot, right, limit
    likely = np.zeros(len(change)) if of is None else _likelihood(*each, of)
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
    """Return the squared normalized innovations, (N,), over the gate: 1 is its edge.

    :param objects: N, predicted, grouped by robot; measured: N, of each.
    """
    robot = errors.robots(np.arange(len(objects)), len(objects))
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
    """Return the states of new objects, which stand or move as their kind allows.

    :param position: (N, 3) a guess at which the first update is linearized [m].
    :param reach: (N,) standard deviation of the guess on each axis, large enough not to matter [m].
    :param measured: ranges by the ground are not used where there are others.
    """
    count, n = len(position), errors.mean.shape[1]
    sigma = np.zeros((count, 2, OF_OBJECT))
    sigma[..., POSITION] = reach[:, None, None]
    sigma[:, MOVES, VELOCITY] = kinds.speed
    sigma[:, STANDS, ALONG_GROUND] = kinds.slow[:, None]
    sigma[..., BIASES] = kinds.sigma[:, None]
    objects = Motions.of(
        np.zeros((count, 2, OF_OBJECT)),
        np.zeros((count, 2, OF_OBJECT, n)),
        np.square(sigma)[..., None] * np.eye(OF_OBJECT),
        np.where(kinds.falls[:, None], [0.0, 1.0], 0.5),
    )
    objects.mean[..., POSITION] = position[:, None]
    part = in_inverse_depth(objects, view.optical)
    robot = errors.robots(np.arange(count), count)
    # pitch errors part the range by the ground from the others, by far more than their noise
    used = measured.used.copy()
    used[two_ranges(measured), PLANE] = False
    measured = replace(measured, used=used)
    step = conditional(part, errors, robot, measured, view, kinds, ground, camera, within=0.0)
    return in_space(step.states, view.optical)


def _corrected(
    P: Floats, change: Floats, step: Updated, robot: Indices, right: Bools
) -> tuple[Floats, Floats, tuple[Floats, Floats]]:
    """Return the camera errors after an update that was linearized at changed errors.

    :param P: (G, 9 C, 9 C) covariance before the update.
    :param change: (G, 9 C) change of the mean at which the step is linearized.
    :return: the covariance, the further change of the mean, and the information, (G, 9 C, 9 C), and
        vector, (G, 9 C), of accepted measurements; see Updated.
    """
    robot, count = robot[right], len(P)
    information = summed(step.information[right], robot, count)
    vector = summed(step.vector[right], robot, count)
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
    of: Indices,
) -> Floats:
    """Return the log likelihood of measurements, (G,); parameters as for :func:`_corrected`.

    :param change: (G, 9 C) total change of the errors, including the further one.
    :param told: information and vector, as returned by :func:`_corrected`.
    """
    (information, vector), (each, at_edge) = told, step.likelihoods(of, limit)
    at = change - further
    log = summed(each[right], robot[right], len(P))
    # log likelihood of a Gaussian in the errors, linearized away from its mean
    bent = (information @ at[..., None])[..., 0]
    A = np.eye(vector.shape[1]) + P @ information
    log -= (at * (vector + bent / 2)).sum(axis=1) + np.linalg.slogdet(A)[1] / 2
    log += ((vector + bent) * change).sum(axis=1) / 2
    # a refused measurement counts as one at the edge of the gate
    return log + summed(at_edge[~right], robot[~right], len(P))
