"""How the robot moves at the time of a picture, by its poses shortly before."""

from collections.abc import Callable
import math

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.poses import TransformError

STEP_BACK = 0.06
"""Time between the poses that are compared [s]. A robot whose turn rate swings by 60 degrees/s
within 3 s is then mistaken by 0.3 degrees/s, and one whose poses are off by 1 mrad by 2.4
degrees/s: with stamps that are 50 ms apart, by 0.3 and 2 mrad. Chosen."""

EARLIER = -STEP_BACK * np.array([1.0, 2.0])
"""Times of the earlier poses [s]."""

VELOCITY_BY_STEPS = np.array([2.0, -0.5]) / -STEP_BACK
"""Velocity by the steps to the earlier poses, at the end of the parabola through all three."""


def way_at(pose_at: Callable[[int], Pose], stamp: int, base: Pose) -> Floats | None:
    """Return the velocity of the robot, (6,), in its own frame, see View; None if it is not known.

    By the parabola through three poses, or by the chord if two are known.

    :param pose_at: returns the pose at a time [ns], or raises TransformError.
    :param stamp: of the picture [ns]; base: the pose at it.
    """
    steps = []
    for since in EARLIER:
        try:
            there = pose_at(stamp + round(since * NANOSECONDS))
        except TransformError:
            break
        R = base.R.T @ there.R
        # the antisymmetric part is the sine of the angle, along the axis
        sines = (R - R.T)[[2, 0, 1], [1, 2, 0]] / 2
        sine = min(float(np.linalg.norm(sines)), 1.0)
        turn = sines * (math.asin(sine) / sine if sine > 0 else 1.0)
        steps.append(np.append((there.t - base.t) @ base.R, turn))
    if len(steps) == len(EARLIER):
        return np.asarray(VELOCITY_BY_STEPS @ steps)
    return steps[0] / EARLIER[0] if steps else None
