"""Motion of objects between pictures: standing, rolling or flying, with switches between them.

The interacting multiple model (Blom and Bar-Shalom 1988; Bar-Shalom, Li and Kirubarajan 2001,
11.6.6) has two hypotheses: an object stands, or it moves like other objects of its color. Falling
objects do not stand; their hypotheses are that they fly on, or that they have been thrown or hit
since they were last measured.
"""

import math

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.flight import fall
from colortrack_ros.world.state import add_white
from colortrack_ros.world.state import ALONG_GROUND
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import MOVES
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import STANDS
from colortrack_ros.world.state import VELOCITY

SOJOURN = 10.0
"""Mean time for which objects stand and for which they move [s], and until a rolling object is
kicked or hits a wall. Assumed: between a ball that is pushed about and a chair."""

FLIGHTS = 60.0
"""Mean time until a falling object is thrown or kicked again [s]. Assumed."""

THROWN = 3.0
"""Standard deviation of the change of vertical velocity by a throw or a kick [m/s]: the speed after
a fall from 0.5 m. The horizontal change has that of the initial speed. Assumed."""

EVENLY = 0.02
"""Share of `wander` by which slow velocities change: 0.01 m/s within a second by default, as on a
floor that is not quite level. With 0.04, what rests before a robot that drives is 1.9 instead of
1.7 % of the range away from 2 s on (`benchmark/world.py`); with 0, balls that slow down by
0.05 m/s^2 are in their 95 % ellipsoid in 82 instead of 89 % of the rows (60 runs, seed 3)."""

LEAST_KICKED = 1e-3
"""Probability that a kicked object stops at once. Assumed."""


def predict(
    objects: Motions, errors: CameraErrors, kinds: Kinds, ground: float, dt: float, unseen: Bools
) -> None:
    """Predict all states in place: standing, constant velocity, or free fall with bounces.

    :param ground: height of the ground in the fixed frame [m].
    :param dt: [s].
    :param unseen: (N,) whether an object may be thrown, kicked or hit a wall without being seen.
    """
    thrown = _mix(objects, errors, kinds, dt, unseen)
    _maneuver(objects, errors, kinds, dt, unseen & ~kinds.falls)
    _move(objects.whole[:, MOVES], kinds.wander, dt)
    if np.count_nonzero(slow := kinds.slow > 0):
        other = objects.whole[slow, STANDS]
        _move(other, EVENLY * kinds.wander[slow], dt)
        objects.whole[slow, STANDS] = other
    if np.count_nonzero(kinds.falls):
        apart = kinds.falls & (thrown < 1)
        other = objects.whole[apart, STANDS]
        _move(other, kinds.wander[apart], dt)
        objects.whole[apart, STANDS] = other
        fall(objects, errors, kinds, ground, dt, apart)
        _throw(objects, kinds, thrown, dt)


def _move(whole: Floats, wander: Floats, dt: float) -> None:
    """Move objects at constant velocity, in place.

    :param whole: (N, 8, 8 + 8 C + 1) covariances, slopes, and means, side by side.
    :param wander: (N, 3); see Kinds.
    """
    cov = whole[..., :OF_OBJECT]
    whole[:, POSITION] += dt * whole[:, VELOCITY]
    cov[:, :, POSITION] += dt * cov[:, :, VELOCITY]
    add_white(cov, np.square(wander) * dt, dt)


def _maneuver(
    objects: Motions, errors: CameraErrors, kinds: Kinds, dt: float, unseen: Bools
) -> None:
    """Let moving objects redraw their velocity at any time of the step, in place.

    The result is the mixture of both cases, moment-matched. Visible objects do not need this: their
    measurement would be refused, and the object treated as kicked.

    :param unseen: (N,) which objects may do so.
    """
    (rows,) = unseen.nonzero()
    if not len(rows):
        return
    moving = objects.take(rows)
    whole, cov = moving.whole[:, MOVES], moving.cov[:, MOVES]
    B, v = whole[:, VELOCITY, OF_OBJECT:-1], whole[:, VELOCITY, -1]
    P = errors.cov[errors.robots(rows, len(objects))]
    second = cov[:, VELOCITY, VELOCITY] + B @ P @ B.swapaxes(1, 2) + v[:, :, None] * v[:, None, :]
    change, axis = 1 - np.exp(-dt / SOJOURN), np.arange(3, 6)
    whole[:, VELOCITY] *= 1 - change
    cov[:, :, VELOCITY] *= 1 - change
    cov[:, VELOCITY, VELOCITY] += change * (1 - change) * second
    cov[:, axis, axis] += change * np.square(kinds.speed[rows])
    objects.put(rows, moving)


def _throw(objects: Motions, kinds: Kinds, thrown: Floats, dt: float) -> None:
    """Let falling objects be thrown at any time of the step, in the other hypothesis, in place.

    :param thrown: (N,) share of the objects in that hypothesis that are thrown in this step.
    """
    new, rows = kinds.falls & (thrown == 1), kinds.falls
    objects.whole[new, STANDS] = objects.whole[new, MOVES]
    sigma = np.maximum(kinds.speed[rows], [0.0, 0.0, THROWN])
    cov = objects.cov[rows, STANDS]
    add_white(cov, thrown[rows, None] * np.square(sigma), dt)
    objects.cov[rows, STANDS] = cov


def kicked(objects: Motions, speed: Floats, T: Floats) -> Motions:
    """Return states of objects that were kicked, or hit a wall, within the last T.

    The velocity v is redrawn at a time uniformly distributed over T: the position moves by -v T/2,
    with the covariance v v^T T^2/12 + speed^2 T^2/3 (see estimation.gaussian.turned()).

    :param speed: (N, 3) standard deviation of the new velocity [m/s]; T: (N,) [s].
    """
    kicked = objects.take(np.arange(len(objects)))
    mean, slope, cov = (a[:, MOVES] for a in (kicked.mean, kicked.slope, kicked.cov))
    half, T = mean[:, VELOCITY] * (T / 2)[:, None], T[:, None]
    mean[:, POSITION] -= half
    slope[:, POSITION] -= slope[:, VELOCITY] * (T / 2)[..., None]
    kicked.whole[:, MOVES, VELOCITY], cov[:, :, VELOCITY] = 0.0, 0.0
    cov[:, POSITION, POSITION] += half[:, :, None] * half[:, None, :] / 3
    axis, variance = np.arange(3), np.square(speed)
    cov[:, axis, axis] += variance * T * T / 3
    cov[:, axis + 3, axis + 3] = variance
    cov[:, axis, axis + 3] = cov[:, axis + 3, axis] = variance * T / 2
    kicked.probability[:] = [LEAST_KICKED, 1 - LEAST_KICKED]
    return kicked


def _mix(objects: Motions, errors: CameraErrors, kinds: Kinds, dt: float, unseen: Bools) -> Floats:
    """Mix the hypotheses in place, as standing objects start to move and moving objects stop.

    What was thrown flies on once it is measured. Until then it stays apart: what lies, unless it
    was thrown, is no Gaussian. Merged, the height of a ball that lies for 2 s out of sight has a
    deviation of 0.05 m; with those that were thrown, it is 0.08 m.

    :param unseen: (N,) which objects were not measured in the last picture.
    :return: (N,) share of the objects in the hypothesis STANDS that came from the other one.
    """
    whole, cov, p, falls = objects.whole, objects.cov, objects.probability, kinds.falls
    stop = 1 - np.exp(-dt / np.where(falls, FLIGHTS, SOJOURN))
    start = np.where(falls, ~unseen, stop) if np.count_nonzero(falls) else stop
    from_moving = p[:, MOVES, None] * np.array([stop, 1 - stop]).T
    from_standing = p[:, STANDS, None] * np.array([1 - start, start]).T
    after = from_standing + from_moving
    # share of the objects in each hypothesis after mixing that moved before
    moved = from_moving / np.maximum(after, TINY)
    between = whole[:, MOVES, :, OF_OBJECT:] - whole[:, STANDS, :, OF_OBJECT:]
    spread = errors.spread(between[..., :-1], between[..., -1])
    stays = (1 - moved[:, STANDS])[:, None, None]
    rows, columns = stays * whole[:, STANDS, VELOCITY], stays * cov[:, STANDS, :, VELOCITY]
    flat = whole.reshape(len(whole), 2, math.prod(whole.shape[2:]))
    flat[:] = np.concatenate([1 - moved[..., None], moved[..., None]], axis=-1) @ flat
    cov += (moved * (1 - moved))[..., None, None] * spread[:, None]
    begun = (1 - moved[:, MOVES]) * ~falls
    speeds = np.einsum('nii->ni', cov[:, MOVES, VELOCITY, VELOCITY])  # a view
    speeds += begun[:, None] * np.square(kinds.speed)
    # what stops is slow at first, in another direction than before
    others = ~falls[:, None, None]
    np.copyto(whole[:, STANDS, VELOCITY], rows, where=others)
    np.copyto(cov[:, STANDS, :, VELOCITY], columns, where=others)
    speeds = np.einsum('nii->ni', cov[:, STANDS, ALONG_GROUND, ALONG_GROUND])
    speeds += (moved[:, STANDS] * np.square(kinds.slow))[:, None]
    objects.probability[:] = after
    return np.asarray(moved[:, STANDS])


def drift(
    objects: Motions, errors: CameraErrors, robot: Floats, way: Floats, turned: float, sigma: Floats
) -> None:
    """Add the errors of odometry to positions in the odometry frame, in place.

    Its drift adds to the covariances. If ways are longer than it tells, what stands comes nearer by
    the rest.

    :param robot: (3,) its position [m].
    :param way: (3,) and turned: since the last picture [m], [rad].
    :param sigma: (2,) standard deviations of the drift per 1 m and per 1 rad.
    """
    across = objects.mean[..., 1::-1] - robot[1::-1]
    across[..., 0] *= -1
    added = (sigma[1] ** 2 * turned * across)[..., None] * across[..., None, :]
    added += sigma[0] ** 2 * math.hypot(*way) * np.eye(2)
    objects.cov[..., :2, :2] += added
    if not errors.scaled:
        return
    objects.slope[..., POSITION, -1] -= way
    longer = np.repeat(errors.mean[:, -1], len(objects) // len(errors.mean))
    objects.mean[..., POSITION] -= longer[:, None, None] * way
