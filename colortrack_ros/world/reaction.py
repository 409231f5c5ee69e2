"""Reaction: what a robot still does of what it was told, and how late it does it.

Plain Python: takes commands and poses of odometry; returns poses and words.
"""

from collections import deque
from itertools import chain
from itertools import islice
import math

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.poses import Pose

COMMANDS_KEPT = 7.0
"""Time for which commands and headings are kept [s]: SWINGS_WATCHED, the longest reaction, and
LATEST_TURN."""

SWINGS_WATCHED, HEADING_STEP = 4.0, 0.1
"""Time that is looked at [s], two swings of a robot that swings since it is late; its steps [s]."""

LATEST_TURN = 1.5
"""Longest time beside the reaction that is looked for [s]: later robots hardly follow. Chosen."""

TURNS_LATER, EXPLAINED_BY, LEAST_MISFIT = 0.3, 0.5, 0.1
"""A robot is late if turns that are TURNS_LATER [s] or more later leave EXPLAINED_BY of a misfit
of LEAST_MISFIT [rad/s] or more as told, and of its turns: 0.1 to 0.3 of both, but 0.8 and more
if it is somebody else who turns it. With the gains as given, robots that are late by 0.2 s follow
well, and those that are by 0.4 s begin to swing (test_reaction.py). Chosen."""

LATE_LOOKS = 3
"""Looks in a row, one a second, that must agree. Chosen."""


class Commands:
    """The commands of the last seconds, and what the robot makes of them."""

    def __init__(self) -> None:
        self._given: deque[tuple[int, float, float]] = deque()

    @property
    def last(self) -> tuple[float, float]:
        """The last command [m/s], [rad/s]."""
        return self._given[-1][1:] if self._given else (0.0, 0.0)

    def give(self, now: int, speed: float, turn: float) -> None:
        """Note a command [m/s], [rad/s]; if time [ns] has gone back, those before are void."""
        if self._given and now < self._given[-1][0]:
            self._given.clear()
        self._given.append((now, speed, turn))
        while self._given[0][0] < now - COMMANDS_KEPT * NANOSECONDS:
            self._given.popleft()

    def carried_out(self, base: Pose, start: int, end: int) -> tuple[Floats, float]:
        """Return where the robot is after the commands of a time, (2,) [m], and its heading [rad].

        :param base: its pose before them; start, end: of the time [ns].
        """
        (x, y), heading = base.t[:2].tolist(), math.atan2(base.R[1, 0], base.R[0, 0])
        following = (given[0] for given in islice(self._given, 1, None))
        for (since, speed, turn), until in zip(self._given, chain(following, [end]), strict=False):
            dt = (min(until, end) - max(since, start)) / NANOSECONDS
            if dt > 0:
                middle = heading + turn * dt / 2
                x, y = x + speed * dt * math.cos(middle), y + speed * dt * math.sin(middle)
                heading += turn * dt
        return np.array([x, y]), heading

    def turned(self, times: Floats) -> Floats:
        """Return by how much it was told to turn until these times [s], (N,) [rad]."""
        since, turns = (np.array([given[k] for given in self._given], float) for k in (0, 2))
        since /= NANOSECONDS
        so_far = np.append(0.0, np.cumsum(turns[:-1] * np.diff(since)))
        which = np.clip(np.searchsorted(since, times, 'right') - 1, 0, None)
        told = so_far[which] + turns[which] * (times - since[which])
        return np.where(times < since[0], 0.0, told)


class TurnWatch:
    """Watches how late a robot turns after it is told to.

    :ivar line: by how much, in words; empty if it is no later than is said.
    """

    def __init__(self) -> None:
        self.line, self._agreed, self._looked = '', 0, 0
        self._headings: deque[tuple[int, float]] = deque()

    def see(self, commands: Commands, at: int, base: Pose, reaction: float) -> None:
        """Take a pose of odometry.

        :param at: its time [ns].
        :param reaction: how late the robot is said to be [s].
        """
        if self._headings and at == self._headings[-1][0]:
            return
        if self._headings and at < self._headings[-1][0]:
            self._headings.clear()
        self._headings.append((at, math.atan2(base.R[1, 0], base.R[0, 0])))
        while self._headings[0][0] < at - COMMANDS_KEPT * NANOSECONDS:
            self._headings.popleft()
        if abs(at - self._looked) >= NANOSECONDS:
            self._looked = at
            self._look(commands, reaction)

    def _look(self, commands: Commands, reaction: float) -> None:
        stamps, headings = np.array(self._headings).T
        stamps = stamps / NANOSECONDS
        times = np.arange(stamps[-1] - SWINGS_WATCHED, stamps[-1], HEADING_STEP)
        if times[0] < stamps[0]:
            return
        turned = np.diff(np.interp(times, stamps, np.unwrap(headings))) / HEADING_STEP
        taus = reaction + np.append(0.0, np.arange(TURNS_LATER, LATEST_TURN, HEADING_STEP))
        told = np.diff(commands.turned(times - taus[:, None]), axis=1) / HEADING_STEP
        off = np.sqrt(np.mean(np.square(turned - told), axis=1))
        best = int(off.argmin())
        most = min(off[0], float(np.sqrt(np.mean(np.square(turned)))))
        late = best > 0 and off[0] >= LEAST_MISFIT and off[best] <= EXPLAINED_BY * most
        self._agreed = self._agreed + 1 if late else 0
        self.line = ''
        if self._agreed >= LATE_LOOKS:
            self.line = (
                f'the robot turns {taus[best]:.1f} s after it is told to, by odometry, so that it '
                f'may swing to and fro: set reaction to that, which is {reaction:g} s, and '
                'stop_within to more'
            )
