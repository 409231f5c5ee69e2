"""All that stood sets off at once: the robot moves otherwise than odometry tells.

Odometry that dies while the robot drives, or that drives on while wheels slip, makes all objects
set off at the same time, by one motion of the robot: forward, and a turn. This motion is estimated
from their directions by least squares, and compared with that of odometry. Objects that roll alike
all the time are not told: something has to have changed for all of them. Those that set off
together, as on a belt that starts, look the same: so this is told, and nothing is held back.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.objects import Objects
from colortrack_ros.world.poses import NO_ROBOT
from colortrack_ros.world.standing import Sights
from colortrack_ros.world.state import CREEP
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.state import VELOCITY
from colortrack_ros.world.stuck import AGREEMENTS
from colortrack_ros.world.stuck import UNLIKE
from colortrack_ros.world.view import View

SPAN = 1.4
"""Time over which directions are compared [s]: at 0.2 m/s, 3 m away and to the side, they change by
4 degrees. Chosen."""

EXACT = 0.004
"""Error of a change of direction [rad] beside UNLIKE of it: 4 times ANGLE_SIGMA. Chosen."""

LEAST_WAY, LEAST_ANGLE, LEAST_EXCESS = 0.1, 0.1, 0.2
"""By how much the motion that is seen differs at least from that of odometry: [m], or [rad], and
this share of the larger one. Ranges by the ground are off by 17 % at 4 m for 1 degree of pitch.
Chosen."""

FAR = 1e6
"""Distance at which no way of the robot changes a direction [m]."""

MOTION_STEPS = 5
"""Gauss-Newton steps for the motion: bearings are almost linear in it. Chosen."""

WEIGHT, MOST_STEP = 1e-6, 1.0
"""Weight of no motion against that of directions, and longest step, [m] and [rad]: so that what is
far away, and directions of no motion, end somewhere. 4 m against EXACT. Chosen."""

DIFFERENCE = 1e-5
"""Step of its finite differences, [m] and [rad]: the root of the precision of directions."""


@dataclass(frozen=True)
class _Look:
    """What one picture shows of N located objects, in the frame of the robot.

    :ivar tracks: (N,) ascending.
    :ivar ways: (N, 3) unit vectors; far: (N,) distances from the camera [m].
    :ivar stands: (N,) whether they surely stand in the fixed frame.
    """

    stamp: int
    view: View
    tracks: NDArray[np.int64]
    ways: Floats
    far: Floats
    stands: Bools


class SettingOff:
    """Watch over the looks of one camera; see the module."""

    def __init__(self) -> None:
        self._looks: deque[_Look] = deque()
        self._agreeing, self._agreed, self.line = 0, 0, ''

    def see(self, stamp: int, view: View, sights: Sights, objects: Objects, camera: int) -> None:
        """Compare a look with one SPAN ago.

        :param objects: after this picture; camera: index of the camera that took it.
        """
        if view.base is NO_ROBOT:
            return
        if self._looks and stamp <= self._looks[-1].stamp:
            self._looks.clear()
        new = _look(stamp, view, sights, objects, camera)
        # told until something stands: that nothing is in sight contradicts nothing
        if len(new.tracks) and new.stands.all():
            self.line = ''
        self._looks.append(new)
        while len(self._looks) > 1 and stamp - self._looks[1].stamp >= SPAN * NANOSECONDS:
            self._looks.popleft()
        line, others = _compared(self._looks[0], new)
        if others or stamp - self._agreed > SPAN * NANOSECONDS:
            self._agreeing = self._agreeing + others if line else 0
            self._agreed = stamp
        if line and self._agreeing >= AGREEMENTS:
            self.line = line


def _look(stamp: int, view: View, sights: Sights, objects: Objects, camera: int) -> _Look:
    own = objects.track_id[:, camera]
    row, which = (own[:, None] == sights.track).nonzero()
    order = np.argsort(own[row])
    row, which = row[order], which[order]
    row, which = (a[~objects.kinds.falls[row]] for a in (row, which))
    mean, cov = objects.belief.take(row).combined()
    ways = sights.rays[which] @ (view.base.R.T @ view.optical.R).T
    far = np.linalg.norm(mean[:, POSITION] - view.optical.t, axis=1)
    speed = np.linalg.norm(mean[:, VELOCITY], axis=1)
    unsure = np.sqrt(np.trace(cov[:, VELOCITY, VELOCITY], 0, 1, 2))
    return _Look(stamp, view, own[row], ways, far, (speed < CREEP) & (unsure < 2 * CREEP))


def _compared(last: _Look, new: _Look) -> tuple[str, int]:
    """Return a line if all that stood set off alike, and how many tell beside the first.

    Without two that stood nothing can be told.
    """
    stood = last.stands & np.isin(last.tracks, new.tracks)
    same = np.isin(new.tracks, last.tracks[stood])
    now = new.ways[same]
    if len(now) < 2:
        return '', 0
    if new.stands[same].any():
        return '', len(now) - 1
    way = last.view.base.inverse() @ new.view.base
    turn = float(np.arctan2(way.R[1, 0], way.R[0, 0]))
    told = np.array([way.t[:2] @ [np.cos(turn / 2), np.sin(turn / 2)], turn])
    before, eye = last.ways[stood], last.view.mount.t
    points = eye + last.far[stood, None] * before
    seen = _motion(points, eye, now)
    ways = np.stack([_ways(points, eye, motion) for motion in (told, seen)])
    # ranges are uncertain: directions by a way are, those by a turn are not
    turns = np.stack([_ways(eye + FAR * before, eye, motion) for motion in (told, seen)])
    off, left = np.linalg.norm(now - ways, axis=2)
    by_told, by_seen = EXACT + UNLIKE * np.linalg.norm(ways - turns, axis=2)
    # what is straight ahead and far away hardly changes its direction
    against = np.count_nonzero(off > 2 * by_told)
    fits = left < by_seen
    least = [LEAST_WAY, LEAST_ANGLE] + LEAST_EXCESS * np.maximum(np.abs(seen), np.abs(told))
    if against < 2 or not (fits.all() and (np.abs(seen - told) > least).any()):
        return '', len(now) - 1
    (s, a), (s_told, a_told) = ((x[0], np.degrees(x[1])) for x in (seen, told))
    return (
        f'all that stood sets off at once, as if the robot had driven {s:+.2f} m and turned by '
        f'{a:+.0f} degrees in {(new.stamp - last.stamp) / NANOSECONDS:.1f} s, by odometry '
        f'{s_told:+.2f} m and {a_told:+.0f} degrees: odometry is stuck or wrong, wheels slip, or '
        'all objects move alike'
    ), against - 1


def _motion(points: Floats, eye: Floats, now: Floats) -> Floats:
    """Return the motion, way [m] and turn [rad], after which points that stand are seen so.

    :param points: (N, 3) in the frame of the robot before; eye: (3,) of the camera in it.
    :param now: (N, 3) unit vectors after it.
    """
    motion = np.zeros(2)
    for _ in range(MOTION_STEPS):
        at = _ways(points, eye, motion)
        J = np.stack(
            [(_ways(points, eye, motion + step) - at).ravel() for step in DIFFERENCE * np.eye(2)],
            axis=1,
        )
        J /= DIFFERENCE
        step = np.linalg.solve(J.T @ J + WEIGHT * np.eye(2), J.T @ (now - at).ravel())
        motion = motion + np.clip(step, -MOST_STEP, MOST_STEP)
    return motion


def _ways(points: Floats, eye: Floats, motion: Floats) -> Floats:
    """Return the unit vectors, (N, 3), to points after a motion, in the frame of the robot."""
    way, turn = motion
    c, s = np.cos(turn), np.sin(turn)
    moved = points - way * np.array([np.cos(turn / 2), np.sin(turn / 2), 0.0])
    to = moved @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) - eye
    return np.asarray(to / np.linalg.norm(to, axis=1, keepdims=True))
