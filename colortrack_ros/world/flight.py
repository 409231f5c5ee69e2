"""Flight of thrown and bouncing objects: gravity, the air, and the ground."""

import numpy as np
from scipy.special import ndtr

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.state import add_white
from colortrack_ros.world.state import ALONG_GROUND
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import DRAG
from colortrack_ros.world.state import GRAVITY
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import MOVES
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import STANDS
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

FALLS = np.array([2, 5])
"""Height and vertical speed in a state."""

LEAST_FALL = 1e-10
"""Added to the variances of both [m^2], [m^2/s^2], so that they can be inverted."""


def _normal_points() -> tuple[Floats, Floats]:
    """Return points of two independent normal variables, (2, 441), and their weights, (441,).

    They reach as far as LEAST_BOUNCE, and are so many that bounces are as likely as they should be
    to 7 %. Chosen.
    """
    steps = np.linspace(-3.5, 3.5, 21)
    points = np.stack(np.meshgrid(steps, steps)).reshape(2, -1)
    weights = np.exp(-np.square(points).sum(axis=0) / 2)
    weights /= weights.sum()
    return points / np.sqrt(weights @ np.square(points[0])), weights


FALL_POINTS, FALL_WEIGHTS = _normal_points()
FALL_MOMENTS = np.array(
    [
        w * np.array([1, p, q, p * p, p * q, q * p, q * q])
        for w, p, q in zip(FALL_WEIGHTS, *FALL_POINTS, strict=True)
    ]
)
"""Of each point what sums up to the probability, mean, and square of those that touch, (441, 7)."""


def fall(
    objects: Motions, errors: CameraErrors, kinds: Kinds, ground: float, dt: float, apart: Bools
) -> None:
    """Apply air, gravity, and bounces to the falling ones of objects that have moved, in place.

    :param ground: height of the ground in the fixed frame [m].
    :param dt: time for which they have moved [s].
    :param apart: (N,) which fall in the hypothesis STANDS as well.
    """
    (moves,), (thrown,) = kinds.falls.nonzero(), apart.nonzero()
    rows = np.concatenate([moves, thrown])
    each = rows, np.repeat([MOVES, STANDS], [len(moves), len(thrown)])
    whole, kinds = objects.whole[each], kinds.take(rows)
    _brake(whole, kinds, dt)
    whole[:, 2, -1] -= GRAVITY * dt * dt / 2
    whole[:, 5, -1] -= GRAVITY * dt
    _bounce(whole, errors.cov[errors.robots(rows, len(objects))], kinds, ground)
    objects.whole[each] = whole


def _brake(whole: Floats, kinds: Kinds, dt: float) -> None:
    """Slow falling objects down by the drag of the air, k |v| v, in place.

    On a straight line, v becomes v / (1 + k |v| dt). Spin adds a force of unknown direction, as
    large as a share of the drag.

    :param whole: (N, 8, 8 + 8 C + 1) covariances, slopes, and means, side by side.
    """
    v = whole[:, VELOCITY, -1]
    fast = np.linalg.norm(v, axis=1)[:, None]
    k = np.maximum(kinds.drag + whole[:, DRAG, -1], 0.0)[:, None]
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


def _bounce(moved: Floats, P: Floats, kinds: Kinds, ground: float) -> None:
    """Reflect falling objects that may have reached the ground, in place.

    Whether an object touched the ground within this step is as uncertain as its height, and what
    rises already does not touch it again. So height and vertical speed x are reflected point by
    point, and the result is linearized statistically (Gelb 1974, 6.2): it is A x and a rest that is
    not correlated with x. Both follow from the moments of the points that touch the ground.

    :param moved: (N, 8, 8 + 8 C + 1), see :func:`_brake`.
    :param P: (N, 8 C, 8 C) covariance of the camera errors.
    """
    B, above = moved[:, FALLS, OF_OBJECT:-1], moved[:, FALLS, -1]
    above[:, 0] -= ground + kinds.diameter / 2
    S = moved[:, FALLS[:, None], FALLS] + B @ P @ B.swapaxes(1, 2)
    S += LEAST_FALL * np.eye(2)
    near = ndtr(-above / np.sqrt(S[:, [0, 1], [0, 1]])).prod(axis=1) > LEAST_BOUNCE
    if not near.any():
        return
    (rows,) = near.nonzero()
    whole, L, above = moved[rows], np.linalg.cholesky(S[rows]), above[rows, :, None]
    hits = (-above > L @ FALL_POINTS).all(axis=1)
    share, first, second = np.split(hits @ FALL_MOMENTS, [1, 3], axis=1)
    first, second = first[:, None], second.reshape(-1, 2, 2)
    # of y, x where it hits and else 0: the mean, the covariance with the points, E[y y']
    mean, G = above * share[..., None] + L @ first.swapaxes(1, 2), above * first + L @ second
    square = mean @ above.swapaxes(1, 2) + G @ L.swapaxes(1, 2)
    change = 1 + kinds.bounce[rows, None, None]
    whole[:, FALLS, -1] -= (change * mean)[..., 0]
    F = np.tile(np.eye(OF_OBJECT), (len(rows), 1, 1))
    F[:, FALLS[:, None], FALLS] -= change * np.linalg.solve(
        L.swapaxes(1, 2), G.swapaxes(1, 2)
    ).swapaxes(1, 2)
    whole[..., :-1] = F @ whole[..., :-1]
    cov = whole[..., :OF_OBJECT]
    cov[...] = cov @ F.swapaxes(1, 2)
    rest = square - mean @ mean.swapaxes(1, 2) - G @ G.swapaxes(1, 2)
    cov[:, FALLS[:, None], FALLS] += np.square(change) * rest + RESTITUTION**2 * square
    _rub(whole, P[rows], share)
    moved[rows] = whole


def _rub(whole: Floats, P: Floats, hits: Floats) -> None:
    """Change the speed along the ground at a bounce by a share of what it is, in place.

    :param whole: (N, 8, 8 + 8 C + 1), see :func:`_brake`; P: (N, 8 C, 8 C), see :func:`_bounce`.
    :param hits: (N, 1) probability of the bounce.
    """
    B, v = whole[:, ALONG_GROUND, OF_OBJECT:-1], whole[:, ALONG_GROUND, -1]
    variances = np.einsum('nii->ni', whole[:, ALONG_GROUND, ALONG_GROUND])  # a view
    # v may be uncertain: E[v^2], not the square of its mean
    variances += FRICTION**2 * hits * (variances + (B @ P * B).sum(axis=-1) + v * v)
