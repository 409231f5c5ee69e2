"""Cases of the camera errors in which ranges on the ground are not linear; see belief."""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.estimation.gaussian import normalized
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import OF_OBJECT
from colortrack_ros.world.state import SHIFT
from colortrack_ros.world.state import TILT
from colortrack_ros.world.view import View

PITCH, LIFT = TILT.start - OF_OBJECT + 1, SHIFT.start - OF_OBJECT + 2
"""Indices of the pitch and of the height among the errors of the first camera."""

LOW = 0.05
"""Least relative standard deviation of the height above objects for which it is split. Chosen."""

CASE_WIDTH = 0.6
"""Standard deviation of the pitch within a case, over the total one. Cases are 2.3 of it apart,
close enough that their sum has a single maximum."""

CASE_PITCHES, CASE_WEIGHTS = np.array([-(3**0.5), 0.0, 3**0.5]), np.array([1 / 6, 2 / 3, 1 / 6])
"""Centers and weights of the cases: Gauss-Hermite, exact for moments up to the fifth."""

LEAST_CASE = 1e-300
"""Least weight of a case, for its logarithm. With 1e-9, one with an object above the horizon came
back after 4 s: once its height was learned from there, nothing contradicted it any more."""


def divided(errors: CameraErrors, log_weight: Floats, error: int) -> tuple[CameraErrors, Floats]:
    """Return errors that nothing has measured yet, and log weights, with an error split into cases.

    :param errors: (C R); log_weight: (C, R) of their cases.
    :param error: which one.
    """
    count, before = len(CASE_PITCHES), len(errors.mean)
    sigma = np.sqrt(errors.first[error, error])
    mean, cov = np.tile(errors.mean, (count, 1)), np.tile(errors.cov, (count, 1, 1))
    mean[:, error] += np.repeat(np.sqrt(1 - CASE_WIDTH**2) * sigma * CASE_PITCHES, before)
    cov[:, error, error] *= CASE_WIDTH**2
    weights = np.concatenate([log_weight + w for w in np.log(CASE_WEIGHTS)])
    return CameraErrors(mean, cov, errors.first), weights


def weighed(log_weight: Floats, likely: Floats) -> Floats:
    """Return the log weights of cases, (C, R), after log likelihoods, (C R,)."""
    log = log_weight + likely.reshape(log_weight.shape)
    log -= log.max(axis=0)
    return normalized(np.maximum(normalized(log), np.log(LEAST_CASE)))


def is_low(view: View, kinds: Kinds, ground: float, cov: Floats) -> bool:
    """Whether the camera is so little above objects that its height bends their ranges.

    :param cov: (9 C, 9 C) of the camera errors.
    """
    above = np.abs(view.optical.t[2] - ground - kinds.height[kinds.bound])
    return bool((above * LOW < np.sqrt(cov[LIFT, LIFT])).any())
