"""Odometry that is stuck: it reports one pose with new stamps, while all that is seen turns.

When a robot turns, the directions of all that stands turn about it alike; driving changes them less
and unlike. What rolls past a robot that stands turns by other speeds than its neighbors, unless all
of it moves alike, as on a conveyor belt: so this is told, and nothing is held back.
"""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.poses import NO_ROBOT
from colortrack_ros.world.standing import Sights
from colortrack_ros.world.view import View

STANDS_STILL = 1e-3
"""Motion [m] and turn [rad] between two looks up to which odometry stands: a stuck one repeats its
pose, and parked wheels do not count. Chosen."""

LEAST_TURN = 0.25
"""Least turn that is told [rad/s]: 14 degrees/s. What rolls by at 0.5 m/s, 2 m away, turns as fast.
Chosen."""

UNLIKE = 0.15
"""Largest share of the turn by which that of each object, and its elevation, may differ. Driving at
0.5 m/s, 2 m away, differs by up to 0.2 at 60 degrees/s, but not in all looks. Before a robot that
stands, 2 or 3 balls at 0.15 to 1 m/s are told in 7 of 1,500 times of 6 s; with 0.25 in 20. Chosen.
"""

AGREEMENTS = 3
"""Objects beside the first one whose turns must agree with its own, summed over successive looks:
two objects must do so in three looks, 0.6 s. With 5, and 0.25 above, 8 of 1,500 are told, and in
the room where three balls stand a robot that turns is not. Chosen."""

LEVEL = 0.5
"""Least horizontal part of a direction: of what is nearer to the axis of the turn, directions turn
by the place of the camera as well. Chosen."""


class StuckOdometry:
    """Watch over the looks of one camera; see the module."""

    def __init__(self) -> None:
        self._last: tuple[int, View, dict[int, Floats]] | None = None
        self._agreeing, self._turn = 0, 0.0

    @property
    def line(self) -> str:
        """What to tell, or nothing."""
        if self._agreeing < AGREEMENTS:
            return ''
        return (
            f'odometry stands while all that is seen turns by {np.degrees(self._turn):+.0f} '
            'degrees/s about the robot: it is stuck, or the robot is turned by hand, or all '
            'objects move alike'
        )

    def see(self, stamp: int, view: View, sights: Sights) -> None:
        """Compare a look with the one before."""
        if view.base is NO_ROBOT:
            return
        last, self._last = self._last, (stamp, view, _directions(view, sights))
        if last is None or stamp <= last[0] or max(view.way_since(last[1])) > STANDS_STILL:
            self._agreeing = 0
            return
        then, there = last[2], self._last[2]
        both = sorted(then.keys() & there.keys())
        if len(both) < 2:
            return
        before, now = (np.stack([of[track] for track in both]) for of in (then, there))
        # wrapped to half a turn
        by = np.angle(np.exp(1j * (now - before))) * NANOSECONDS / (stamp - last[0])
        self._turn = -float(by[:, 0].mean())
        by[:, 0] += self._turn
        turns = abs(self._turn) > LEAST_TURN and np.abs(by).max() < UNLIKE * abs(self._turn)
        self._agreeing = self._agreeing + len(both) - 1 if turns else 0


def _directions(view: View, sights: Sights) -> dict[int, Floats]:
    """Return azimuth and elevation in the frame of the robot [rad] by track."""
    rays = sights.rays @ (view.base.R.T @ view.optical.R).T
    level = np.hypot(rays[:, 0], rays[:, 1])
    angles = np.stack([np.arctan2(rays[:, 1], rays[:, 0]), np.arctan2(rays[:, 2], level)], axis=1)
    used = (level > LEVEL) & ~sights.kinds.falls
    return dict(zip(sights.track[used].tolist(), angles[used], strict=True))
