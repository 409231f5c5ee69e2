"""Prediction and update of the states of all objects at once.

The update is that of the iterated extended Kalman filter (Bell and Cathey 1993; Bar-Shalom, Li and
Kirubarajan 2001, 10.5.2): the measurement is linearized again where the last step has led. Biases
are considered, not estimated (Schmidt 1966): their rows of the gain are 0, so that they keep their
variance and what correlates with them is not averaged away.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from colortrack_ros.estimation.gaussian import mixture
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.world.inverse_depth import from_points
from colortrack_ros.world.inverse_depth import to_points
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.state import BIASES
from colortrack_ros.world.state import columns_of
from colortrack_ros.world.state import GRAVITY
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import VELOCITY
from colortrack_ros.world.view import View

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

LATER_STEPS = 2
"""Linearizations of an update: at the prediction, and where that leads."""

FIRST_STEPS = 4
"""Linearizations of the first update, which begins at a guess."""

BIAS_MEMORY = 60.0
"""Time constant of the biases [s], first-order Gauss-Markov: a mount gives, a load shifts, light
moves the edges of blobs. Assumed; at 1e9 `python benchmark/world.py` gives a NEES of 4.3 in place
of 3.6, of 3, for what stands on the ground while the robot drives."""

RESTITUTION = 0.15
"""Standard deviation of the share of speed that is left after a bounce; a measured one of 0.7 with
balls on floors is between 0.5 and 0.9. Assumed."""

LEAST_BOUNCE = 1e-3
"""Probability of a bounce below which it has not been: 3 standard deviations above the ground."""

FARTHER = 4.0
"""How many times farther away a step of an update may take an object: the linearization does not
reach beyond, where 1/Z comes near 0."""

FRICTION = 0.2
"""Standard deviation of the share of the horizontal speed that is lost or gained at a bounce, by
spin: at most 2/7 for a ball that does not spin and then rolls."""


def predict(mean: Floats, cov: Floats, kinds: Kinds, ground: float, dt: float) -> None:
    """One step of all states, in place: constant velocity, or free fall with bounces.

    With w the wander, Q = w^2 [dt^3/3, dt^2/2; dt^2/2, dt] on each axis (white acceleration,
    Bar-Shalom 2001, 6.2.2).

    :param mean: (N, n); cov: (N, n, n).
    :param ground: height of the ground in the fixed frame [m].
    :param dt: [s].
    """
    mean[:, POSITION] += dt * mean[:, VELOCITY]
    mean[:, 2] -= GRAVITY * dt * dt / 2 * kinds.falls
    mean[:, 5] -= GRAVITY * dt * kinds.falls
    cov[:, POSITION] += dt * cov[:, VELOCITY]
    cov[:, :, POSITION] += dt * cov[:, :, VELOCITY]
    # the biases themselves keep their variance; what correlates with them forgets
    cov[:, :6, BIASES] *= np.exp(-dt / BIAS_MEMORY)
    cov[:, BIASES, :6] *= np.exp(-dt / BIAS_MEMORY)
    axis = np.arange(3)
    w2 = np.square(kinds.wander)
    cov[:, axis, axis] += w2 * dt**3 / 3
    cov[:, axis + 3, axis + 3] += w2 * dt
    cov[:, axis, axis + 3] += w2 * dt * dt / 2
    cov[:, axis + 3, axis] += w2 * dt * dt / 2
    _bounce(mean, cov, kinds, ground)


def _bounce(mean: Floats, cov: Floats, kinds: Kinds, ground: float) -> None:
    """Turn the fall of objects that may be in the ground by now, in place.

    Whether one has touched it within this step is as uncertain as its height: the state is that of
    the mixture of both.
    """
    below = (ground + kinds.diameter / 2 - mean[:, 2]) / np.sqrt(np.maximum(cov[:, 2, 2], TINY))
    weight = np.where(kinds.falls & (mean[:, 5] < 0), ndtr(below), 0.0)
    (rows,) = (weight > LEAST_BOUNCE).nonzero()
    if not len(rows):
        return
    weight = weight[rows]
    share, floor = kinds.bounce[rows], ground + kinds.diameter[rows] / 2
    means = np.stack([mean[rows], mean[rows]])
    means[1, :, 2] = floor + share * np.maximum(floor - mean[rows, 2], 0.0)
    means[1, :, 5] *= -share
    covs = np.stack([cov[rows], cov[rows]])
    for at in (2, 5):
        covs[1, :, at] *= -share[:, None]
        covs[1, :, :, at] *= -share[:, None]
    covs[1, :, 5, 5] += np.square(RESTITUTION * mean[rows, 5])
    for at in (3, 4):
        covs[1, :, at, at] += np.square(FRICTION * mean[rows, at])
    mean[rows], cov[rows] = mixture(np.stack([1 - weight, weight]), means, covs)


def drift(cov: Floats, arms: Floats, moved: float, turned: float, sigma: Floats) -> None:
    """Add what odometry adds to the error of positions in its own frame, in place.

    :param arms: (N, 3) from the robot to the objects [m].
    :param moved, turned: since the last picture [m], [rad].
    :param sigma: (2,) of 1 m and of 1 rad.
    """
    across = arms[:, [1, 0]] * [-1, 1]
    cov[:, :2, :2] += sigma[1] ** 2 * turned * across[:, :, None] * across[:, None, :]
    cov[:, [0, 1], [0, 1]] += sigma[0] ** 2 * moved


def update(
    mean: Floats,
    cov: Floats,
    measured: Measured,
    view: View,
    kinds: Kinds,
    ground: float,
    steps: int = LATER_STEPS,
    camera: int = 0,
) -> tuple[Floats, Floats, Floats]:
    """The states after measurements, and how far these were from what was expected.

    :param mean, cov: (N, n), (N, n, n), predicted, in front of the camera.
    :param camera: which of them has measured.
    :return: mean, cov, and the normalized innovation squared of the used rows, (N,), NaN where an
        expected one is not in sight; those states stay as they are.
    """
    start = mean.copy()
    start[:, POSITION], J = from_points(view.optical, mean[:, POSITION])
    cov = _turned(cov, J)
    at, nis = start, np.zeros(0)
    for step in range(steps):
        innovation, H, J = _linearized(start, at, measured, view, kinds, ground, camera)
        PH = cov @ H.swapaxes(1, 2)
        S = H @ PH + measured.R
        K = np.linalg.solve(S, PH.swapaxes(1, 2)).swapaxes(1, 2)
        K[:, BIASES] = 0.0
        if step == 0:
            nis = (innovation * np.linalg.solve(S, innovation[:, :, None])[:, :, 0]).sum(axis=1)
        at = start + (K @ innovation[:, :, None])[:, :, 0]
        at[:, 2] = np.maximum(at[:, 2], start[:, 2] / FARTHER)
    A = np.eye(mean.shape[1]) - K @ H
    cov = A @ cov @ A.swapaxes(1, 2) + K @ measured.R @ K.swapaxes(1, 2)
    after = at.copy()
    after[:, POSITION], J = to_points(view.optical, at[:, POSITION])
    cov = _turned(cov, J)
    nis[~H.any(axis=(1, 2))] = np.nan
    return after, (cov + cov.swapaxes(1, 2)) / 2, nis


def _linearized(
    start: Floats,
    at: Floats,
    measured: Measured,
    view: View,
    kinds: Kinds,
    ground: float,
    camera: int,
) -> tuple[Floats, Floats, Floats]:
    """The innovation, (N, 5), and H, (N, 5, n), linearized at a state in inverse depth.

    Both are 0 in what is not measured, and of objects that would not be seen there.
    """
    point = at.copy()
    point[:, POSITION], J = to_points(view.optical, at[:, POSITION])
    own = columns_of(camera)
    z, of_own = expected(view, point[:, own], kinds.diameter, ground + kinds.height)
    H = np.zeros((*z.shape, at.shape[1]))
    H[:, :, own] = of_own
    H[:, :, POSITION] = H[:, :, POSITION] @ J
    H[~measured.used] = 0.0
    innovation = measured.z - z - (H @ (start - at)[:, :, None])[:, :, 0]
    innovation[~measured.used] = 0.0
    seen = np.isfinite(H).all(axis=(1, 2)) & np.isfinite(innovation).all(axis=1)
    H[~seen], innovation[~seen] = 0.0, 0.0
    return innovation, H, J


def _turned(cov: Floats, J: Floats) -> Floats:
    """Covariances of states, (N, n, n), of which the position is measured otherwise.

    :param J: (N, 3, 3) its Jacobian.
    """
    cov = cov.copy()
    cov[:, POSITION] = J @ cov[:, POSITION]
    cov[:, :, POSITION] = cov[:, :, POSITION] @ J.swapaxes(1, 2)
    return cov


def started(
    position: Floats,
    reach: Floats,
    measured: Measured,
    view: View,
    kinds: Kinds,
    ground: float,
    camera: int = 0,
) -> tuple[Floats, Floats]:
    """States of objects that are seen for the first time.

    :param position: (N, 3) a guess, from which the first update begins [m].
    :param reach: (N,) standard deviation of the guess on each axis, so large that it does not
        count [m].
    """
    sigma = np.concatenate([np.repeat(reach[:, None], 3, axis=1), kinds.speed, kinds.sigma], axis=1)
    mean = np.zeros_like(sigma)
    mean[:, POSITION] = position
    cov = np.square(sigma)[:, :, None] * np.eye(sigma.shape[1])
    return update(mean, cov, measured, view, kinds, ground, FIRST_STEPS, camera)[:2]
