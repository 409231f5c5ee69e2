"""Worlds drawn from all that the locator is told or assumes, by which world.py judges covariances.

NEES is as expected only where the world is drawn from the prior. So what may roll stands or rolls
with even odds at first, sets off and stops, and out of sight draws its speed anew; what falls meets
air and spin, bounces, and is thrown again; and errors of the camera change. All of it is read from
the kinds and the constants of the library. Only the noise of PLANE, measured as 0, is not drawn.
"""

import numpy as np
from world_scene import truths

from colortrack_ros.world.filter import ERROR_MEMORY
from colortrack_ros.world.flight import FLIGHT
from colortrack_ros.world.flight import FRICTION
from colortrack_ros.world.flight import RESTITUTION
from colortrack_ros.world.flight import SPIN
from colortrack_ros.world.motion import FLIGHTS
from colortrack_ros.world.motion import SOJOURN
from colortrack_ros.world.motion import THROWN
from colortrack_ros.world.state import CREEP
from colortrack_ros.world.state import DRAG
from colortrack_ros.world.state import GRAVITY
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import VELOCITY


def moving(truth):
    """Which objects move, (N, 1)."""
    return truth[:, VELOCITY].any(axis=1, keepdims=True)


def begun_as_told(scene, motion, runs, objects, kinds, errors, rng):
    """The first states, (runs * objects, 16), as truths() draws them, with velocities as told."""
    truth = truths(scene, motion, runs, objects, kinds, errors, rng)
    moves = kinds.falls[:, None] | (rng.random((len(truth), 1)) < 1 / 2)
    truth[:, VELOCITY] = moves * kinds.speed * rng.normal(size=(len(truth), 3))
    return truth


def moved_as_told(truth, kinds, errors, objects, dt, unseen, rng):
    """One step of the true states, and of the errors of the cameras, in place.

    :param errors: before any measurement; objects: of each run; unseen: (N,) in the last picture.
    """
    count = len(truth)
    switch, again = rng.random((2, count, 1)) < 1 - np.exp(-dt / SOJOURN)
    moves, falls = moving(truth), kinds.falls[:, None]
    draws = np.where(moves, again & unseen[:, None], switch) & ~falls
    truth[:, VELOCITY] = np.where(
        draws, kinds.speed * rng.normal(size=(count, 3)), truth[:, VELOCITY]
    )
    truth[:, VELOCITY] *= ~(switch & moves) | falls
    truth[:, POSITION] += dt * truth[:, VELOCITY]
    speed_up(truth, kinds.wander * moving(truth), dt, rng)
    if falls.any():
        fly(truth, kinds, dt, rng)
    left = np.exp(-dt / ERROR_MEMORY)
    change = rng.normal(size=(count // objects, 8)) * np.sqrt(1 - left**2)
    change *= np.sqrt(np.diag(errors.first)[:8])
    truth[:, 8:] = left * truth[:, 8:] + np.repeat(change, objects, axis=0)


def speed_up(truth, sigma, dt, rng):
    """Add a white acceleration within a step, in place; sigma: (N, 3), of velocity within 1 s."""
    change, apart = rng.normal(size=(2, len(truth), 3)) * sigma * np.sqrt(dt)
    truth[:, VELOCITY] += change
    truth[:, POSITION] += dt * (change / 2 + apart / np.sqrt(12))


def fly(truth, kinds, dt, rng):
    """Let objects that have moved for a step fall, bounce and be thrown, in place."""
    count, floor, v = len(truth), kinds.diameter / 2, truth[:, VELOCITY]
    fast = np.linalg.norm(v, axis=1, keepdims=True)
    k = np.maximum(kinds.drag + truth[:, DRAG], 0.0)[:, None]
    lost = (1 / (1 + k * fast * dt) - 1) * v
    v += lost
    truth[:, POSITION] += dt / 2 * lost
    speed_up(truth, SPIN * k * fast**2 * np.sqrt(FLIGHT), dt, rng)
    truth[:, 2] -= GRAVITY * dt * dt / 2
    truth[:, 5] -= GRAVITY * dt
    down = (truth[:, 2] < floor) & (truth[:, 5] < 0)
    # what has fallen for two steps or less lies, and rolls
    hits = (down & (truth[:, 5] < -2 * GRAVITY * dt))[:, None]
    truth[:, 3:5] *= 1 + FRICTION * hits * rng.normal(size=(count, 2))
    share = rng.normal(kinds.bounce, RESTITUTION)[down]
    truth[down, 2] = floor[down] + share * (floor[down] - truth[down, 2])
    truth[down, 5] *= -share
    thrown = rng.random((count, 1)) < 1 - np.exp(-dt / FLIGHTS)
    sigma = np.maximum(kinds.speed, [0.0, 0.0, THROWN])
    change = thrown * sigma * rng.normal(size=(count, 3))
    truth[:, VELOCITY] += change
    # at any time of the step
    truth[:, POSITION] += dt * rng.random((count, 1)) * change


def published(truth, rng):
    """The states, whose velocities creep where they stand by what is published of such ones."""
    shown = truth.copy()
    shown[:, VELOCITY] += CREEP * ~moving(truth) * rng.normal(size=(len(truth), 3))
    return shown
