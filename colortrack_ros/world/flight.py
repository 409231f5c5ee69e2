"""Flight of thrown and bouncing objects: gravity, the air, and the ground."""

import numpy as np
from scipy.special import ndtr

from colortrack_ros.data import Floats
from colortrack_ros.estimation.gaussian import mixture
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.state import add_white
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import DRAG
from colortrack_ros.world.state import GRAVITY
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import MOVES
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import VELOCITY

SPIN = 0.5
"""Standard deviation, on each axis, of the force of spin over drag: lift coefficients of spinning
balls reach 0.3, drag coefficients are about 0.5."""

FLIGHT = 0.5
"""Time for which this force keeps its direction [s]: from throw to bounce. Assumed."""

RESTITUTION = 0.15
"""Standard deviation of the restitution; measured values for balls on floors, around 0.7, lie
between 0.5 and 0.9. Assumed."""

LEAST_BOUNCE = 1e-3
"""Probability below which a bounce is ignored: 3 standard deviations above the ground."""

FRICTION = 0.2
"""Standard deviation of the relative change of horizontal speed at a bounce, due to spin; a ball
without spin that then rolls loses at most 2/7."""


def fall(objects: Motions, errors: CameraErrors, kinds: Kinds, ground: float, dt: float) -> None:
    """Apply air, gravity, and bounces to the falling ones of objects that have moved, in place.

    :param ground: height of the ground in the fixed frame [m].
    :param dt: time for which they have moved [s].
    """
    _brake(objects, kinds, dt)
    mean, cov, slope = (a[:, MOVES] for a in (objects.mean, objects.cov, objects.slope))
    mean[:, 2] -= GRAVITY * dt * dt / 2 * kinds.falls
    mean[:, 5] -= GRAVITY * dt * kinds.falls
    P = np.repeat(errors.cov, len(mean) // len(errors.cov), axis=0)
    _bounce(mean, slope, cov, P, kinds, ground)


def _brake(objects: Motions, kinds: Kinds, dt: float) -> None:
    """Slow falling objects down by the drag of the air, k |v| v, in place.

    On a straight line, v becomes v / (1 + k |v| dt). Spin adds a force of unknown direction, as
    large as a share of the drag.
    """
    falls = kinds.falls
    whole = objects.whole[:, MOVES][falls]
    v = whole[:, VELOCITY, -1]
    fast = np.linalg.norm(v, axis=1)[:, None]
    k = np.maximum(kinds.drag[falls] + whole[:, DRAG, -1], 0.0)[:, None]
    left = 1 / (1 + k * fast * dt)
    lost, by_drag = (left - 1) * v, -np.square(left) * fast * dt * v
    along = v[:, :, None] * (v / np.maximum(fast, TINY))[:, None]
    by_v = (left - 1)[..., None] * np.eye(3) - (np.square(left) * k * dt)[..., None] * along
    J = np.concatenate([by_v, by_drag[..., None]], axis=-1)  # of what is lost, by v and the drag
    inputs = [3, 4, 5, DRAG]
    changes = J @ whole[:, inputs]
    changes[..., -1] = lost
    whole[:, VELOCITY] += changes
    whole[:, POSITION] += dt / 2 * changes
    cov = whole[..., :OF_OBJECT]
    changes = cov[..., inputs] @ J.swapaxes(-1, -2)
    cov[..., VELOCITY] += changes
    cov[..., POSITION] += dt / 2 * changes
    force = SPIN**2 * (np.square(k) + cov[:, DRAG, DRAG, None]) * fast**4
    add_white(cov, np.repeat(force * FLIGHT * dt, 3, axis=1), dt)
    objects.whole[falls, MOVES] = whole


def _bounce(
    mean: Floats, slope: Floats, cov: Floats, P: Floats, kinds: Kinds, ground: float
) -> None:
    """Reflect falling objects that may have reached the ground, in place.

    Whether an object touched the ground within this step is as uncertain as its height; the result
    is the mixture of both cases, moment-matched.

    :param mean: (N, 8); slope: (N, 8, 8 C); cov: (N, 8, 8).
    :param P: (N, 8 C, 8 C) covariance of the camera errors.
    """
    (rows,) = (kinds.falls & (mean[:, 5] < 0)).nonzero()
    floor, P, B = ground + kinds.diameter[rows] / 2, P[rows], slope[rows]
    whole = cov[rows] + B @ P @ B.swapaxes(1, 2)
    weight = ndtr((floor - mean[rows, 2]) / np.sqrt(np.maximum(whole[:, 2, 2], TINY)))
    near = weight > LEAST_BOUNCE
    if not near.any():
        return
    rows, weight, floor, P, B, whole = (a[near] for a in (rows, weight, floor, P, B, whole))
    share = kinds.bounce[rows]
    means, covs = np.stack([mean[rows]] * 2), np.stack([whole] * 2)
    means[1, :, 2] = floor + share * np.maximum(floor - mean[rows, 2], 0.0)
    means[1, :, 5] *= -share
    for at in (2, 5):
        covs[1, :, at] *= -share[:, None]
        covs[1, :, :, at] *= -share[:, None]
        B[:, at] *= (1 - weight - weight * share)[:, None]
    covs[1, :, 5, 5] += np.square(RESTITUTION * mean[rows, 5])
    for at in (3, 4):
        covs[1, :, at, at] += np.square(FRICTION * mean[rows, at])
    mean[rows], whole = mixture(np.stack([1 - weight, weight]), means, covs)
    slope[rows], cov[rows] = B, whole - B @ P @ B.swapaxes(1, 2)
