"""Odometry that contradicts itself: its poses do not move as its twists tell.

A driver that has died and repeats its last message stands while its twist drives. Poses whose axes
are exchanged, or whose yaw has the wrong sign, drive sideways or turn the other way. No picture is
needed for that, but poses and twists from different sources. Twists that are not filled in are 0,
and tell nothing; some are in the fixed frame instead of the robot's, which is not told here.
"""

from collections import deque
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.poses import Pose

SECONDS = 1.0
"""Time over which both are compared [s]: a late start or a slow filter is shorter. Chosen."""

GAP_BETWEEN = 0.5
"""Longest time between two messages [s] for which a twist stands; robots send 10 a second or more.
Chosen."""

LEAST_DRIVEN, LEAST_TURNED = 0.15, 0.2
"""Least way [m] and turn [rad] by the twists within SECONDS that are compared. Chosen."""

STANDING_SHARE = 0.1
"""Share of the way and of the turn by the twists below which poses stand. Chosen."""

ALONG = 0.5
"""Least cosine between the ways by poses and by twists: within 60 degrees. Chosen."""

Reading = tuple[int, Pose, Floats, float]


class Twists:
    """Watch over the messages of an odometry."""

    def __init__(self) -> None:
        self._readings: deque[Reading] = deque()

    def see(self, stamp: int, pose: Pose, velocity: ArrayLike, turn: float) -> str:
        """Return how a message contradicts those of the last second; empty if it does not.

        :param stamp: [ns]; pose: of the robot in the fixed frame.
        :param velocity: (2,) x, y in the frame of the robot [m/s]; turn: to the left [rad/s].
        """
        readings, v = self._readings, np.asarray(velocity, float)
        since = (stamp - readings[-1][0]) / NANOSECONDS if readings else 0.0
        if not 0 < since < GAP_BETWEEN or not (np.isfinite(v).all() and np.isfinite(turn)):
            readings.clear()
        readings.append((stamp, pose, v, turn))
        if stamp - readings[0][0] < SECONDS * NANOSECONDS:
            return ''
        # a driver that differentiates its poses sends the twist of the step behind it
        line = _contradiction(readings, slice(-1)) and _contradiction(readings, slice(1, None))
        readings.popleft()
        return line


def _contradiction(readings: Iterable[Reading], of_steps: slice) -> str:
    """Return how poses contradict twists.

    :param of_steps: which of the N readings have the twists of the N - 1 steps between them.
    """
    stamps, poses, v, w = zip(*readings, strict=True)
    dt = np.diff(stamps) / NANOSECONDS
    yaw = np.unwrap([np.arctan2(pose.R[1, 0], pose.R[0, 0]) for pose in poses])
    steps = np.diff([pose.t[:2] for pose in poses], axis=0)
    # each step as the robot sees it, and by its twist
    R = np.stack([pose.R[:2, :2] for pose in poses[:-1]])
    own = np.einsum('nij,ni->nj', R, steps)
    told = np.stack(v[of_steps]) * dt[:, None]
    way, turn = np.linalg.norm(told, axis=1).sum(), float(w[of_steps] @ dt)
    driven, turned = np.linalg.norm(steps, axis=1).sum(), yaw[-1] - yaw[0]
    if way > LEAST_DRIVEN and driven < STANDING_SHARE * way:
        return (
            f'its pose stands while its twist drives {way:.2f} m in {dt.sum():.1f} s: it is stuck '
            'and repeats its last message, or the robot is blocked'
        )
    if abs(turn) > LEAST_TURNED and turned * np.sign(turn) < STANDING_SHARE * abs(turn):
        return (
            f'its pose turns by {np.degrees(turned):+.0f} degrees while its twist turns by '
            f'{np.degrees(turn):+.0f} degrees: it is stuck, or its yaw has the wrong sign'
        )
    along = max(float((own * told).sum()), float((steps * told).sum()))
    length = float(np.linalg.norm(own) * np.linalg.norm(told))
    if min(way, driven) > LEAST_DRIVEN and along < ALONG * length:
        x, y = own.sum(axis=0)
        return (
            f'by its poses the robot has driven {x:+.2f} m forward and {y:+.2f} m to the left, by '
            f'its twists {told[:, 0].sum():+.2f} and {told[:, 1].sum():+.2f} m: axes are '
            'exchanged, or x, y or yaw has the wrong sign'
        )
    return ''
