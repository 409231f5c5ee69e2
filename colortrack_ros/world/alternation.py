"""Alternation: a frame goes to and fro, since two sources publish its poses.

A driver and a filter that both publish odom -> base_link in TF disagree by what they have drifted
apart, and what is looked up is in between. Each of them moves steadily; together they go there and
back faster than any robot.
"""

from bisect import bisect_right
from collections import deque
from collections.abc import Sequence
import math
from typing import NamedTuple

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.poses import HARDEST

LEAST_OFF = 0.05
"""Least distance [m] and angle [rad] between two sources: what is seen 1 m away is off by as much.
Those that agree better do little harm. Chosen."""

ALIGNED = 0.97
"""Least cosine between the ways that a frame goes: those of two sources point to and fro along one
line, within 14 degrees, and those of one that is noisy anywhere. Chosen."""

RETURNS, RETURNS_WITHIN = 5, 1.0
"""A frame that goes there and back so often in that time [s] does so by two sources: localization
that jumps goes there alone. Chosen."""

POSES_KEPT = 50
"""Latest poses to look at: half a second at 100 Hz, by which a second source may be late
(WENT_BACK)."""

Stamped = tuple[int, Sequence[float], Sequence[float]]


class Return(NamedTuple):
    """A pose that is off the one before it and the one after it.

    :param moved: distance [m]; angle: [rad].
    :param aside: (3,) from the middle between those two [m].
    """

    moved: float
    angle: float
    aside: list[float]


class Alternation:
    """Watch over the poses of one frame in its parent. Plain Python: TF has hundreds a second."""

    def __init__(self) -> None:
        self._poses: list[Stamped] = []
        self._returns: deque[tuple[int, Return]] = deque(maxlen=RETURNS)

    def see(self, stamp: int, t: Sequence[float], q: Sequence[float]) -> None:
        """Take the next pose, which may be late.

        :param stamp: [ns]; t: (3,) [m]; q: (4,) quaternion.
        """
        after = bisect_right(self._poses, stamp, key=lambda pose: pose[0])
        self._poses.insert(after, (stamp, t, q))
        at = min(after, len(self._poses) - 2)
        if at > 0 and (way := _there_and_back(*self._poses[at - 1 : at + 2])):
            self._returns.append((stamp, way))
        del self._poses[:-POSES_KEPT]

    @property
    def line(self) -> str:
        """How far apart two sources are; empty if the frame moves as one source lets it."""
        if len(self._returns) < RETURNS:
            return ''
        if self._poses[-1][0] - self._returns[0][0] > RETURNS_WITHIN * NANOSECONDS:
            return ''
        ways = [way for _, way in self._returns]
        if not all(_aligned(ways[0].aside, way.aside) for way in ways):
            return ''
        far = max(ways, key=lambda way: max(way.moved, way.angle))
        return f'goes to and fro by {far.moved:.2f} m and {math.degrees(far.angle):.0f} degrees'


def _there_and_back(one: Stamped, two: Stamped, three: Stamped) -> Return | None:
    """Return how far the pose in between is off both others, if these are close."""
    dt = (three[0] - one[0]) / NANOSECONDS
    there, back, after = _way(one, two), _way(two, three), _way(one, three)
    for k, hardest in enumerate(HARDEST):
        off = min(there[k], back[k])
        if off > LEAST_OFF + hardest * dt * dt / 2 and after[k] < off / 2:
            aside = [b - (a + c) / 2 for a, b, c in zip(one[1], two[1], three[1], strict=True)]
            return Return(min(there[0], back[0]), min(there[1], back[1]), aside)
    return None


def _aligned(one: Sequence[float], other: Sequence[float]) -> bool:
    """Return whether two ways [m] lie on one line; short ones, as of turns on the spot, do."""
    lengths = math.hypot(*one), math.hypot(*other)
    along = sum(a * b for a, b in zip(one, other, strict=True))
    return max(lengths) < LEAST_OFF or abs(along) >= ALIGNED * lengths[0] * lengths[1]


def _way(one: Stamped, other: Stamped) -> tuple[float, float]:
    """Return the distance [m] and the angle [rad] between two poses."""
    # those that drivers round are not quite of length 1, which would look like a turn
    lengths = math.hypot(*one[2]) * math.hypot(*other[2]) or 1.0
    cosine = abs(sum(a * b for a, b in zip(one[2], other[2], strict=True))) / lengths
    return math.dist(one[1], other[1]), 2 * math.acos(min(cosine, 1.0))
