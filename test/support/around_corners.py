"""What a robot follows around corners, and how late it learns of it."""

import numpy as np

from colortrack_ros.world.following import Target

SECOND = 1_000_000_000
TICK = 20_000_000
LATENCY = 60_000_000
"""What a picture takes through detector, tracker and locator."""


def around_corners(t, speed=0.4):
    """A square of 2 m."""
    way = speed * t % 8
    side, rest = divmod(way, 2)
    x, y = [(rest, 0), (2, rest), (2 - rest, 2), (0, 2 - rest)][int(side)]
    return 1.0 + x, y


def see_late(following, waiting, target_at, now, seen):
    """Tell of a target LATENCY after it was seen, at every other tick; return where it is now.

    :param waiting: what is on its way, (time of arrival, Target), changed here.
    """
    where = np.array(target_at(now / SECOND))
    if seen(now / SECOND) and now % (2 * TICK) == 0:
        velocity = (np.array(target_at(now / SECOND + 1e-3)) - where) / 1e-3
        waiting.append((now + LATENCY, Target(where, velocity, now, now)))
    while waiting and waiting[0][0] <= now:
        following.see(waiting.pop(0)[1])
    return where
