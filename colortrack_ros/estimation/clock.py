"""Time between stamps, and when a tracker has to restart."""

from collections.abc import Callable

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.stamps import require_stamp


def time_passed(last: int | None, stamp: int, max_dt: float) -> tuple[float, str]:
    """Time step from one frame to the next, or why the tracker has to restart.

    :param last: stamp of the last frame [ns], None before the first.
    :param stamp: of the next frame [ns].
    :param max_dt: a longer jump restarts [s].
    :return: dt [s], 0 for a first frame; and the reason to restart, empty if there is none.
    :raises ValueError: the first stamp is no whole number, as of seconds, in which nothing moves.
    """
    if last is None:
        require_stamp(stamp)
        return 0.0, ''
    dt = (stamp - last) / NANOSECONDS
    if dt < 0:
        return 0.0, f'the stamp went back by {-dt:.6f} s'
    if dt > max_dt:
        return 0.0, f'the stamp jumped ahead by {dt:.6f} s, max_dt is {max_dt:g} s'
    return dt, ''


MOST_STRETCH = 2.5
"""Largest ratio of a jump to the one before at which both are the time between frames. Assumed: one
frame may have been lost, and stamps jitter."""

LONGEST_JUMP = 15.0
"""Longest jump that may be the time between frames [s]: radars of air traffic turn once in 12 s.
Assumed."""


class Clock:
    """A tracker's clock: the stamp of its last frame, and why it last restarted.

    :param follows: follow a source that is slower than any jump allowed, such as a radar that turns
        once in 2.5 s: a jump right after another one is the time between its frames.
    :ivar restarted: the reason, until :meth:`tell_restart` returns it; empty if there is none.
    """

    def __init__(self, *, follows: bool = False) -> None:
        self._stamp: int | None = None
        self._follows, self._jump = follows, 0.0
        self.restarted = ''

    @property
    def now(self) -> int:
        """Stamp of the last frame [ns], 0 before the first."""
        return self._stamp or 0

    def is_now(self, stamp: int) -> bool:
        """Whether the last frame had this stamp [ns]."""
        return stamp == self._stamp

    def restart(self, why: str) -> None:
        """Forget the last frame.

        :param why: reason, to be published with the next tracks.
        """
        self._stamp, self.restarted = None, why

    def advance(self, stamp: int, max_dt: float, reset: Callable[[str], None]) -> float:
        """Go to the next frame.

        :param stamp: of the frame [ns].
        :param max_dt: a longer jump restarts [s].
        :param reset: resets the tracker, this clock included; called with the reason if the stamp
            goes back or jumps.
        :return: dt [s], 0 for a first frame.
        """
        dt, why = time_passed(self._stamp, stamp, max_dt)
        if why:
            dt = self._time_of_slow(stamp)
            if not dt:
                reset(why)
        elif dt:  # else there is more of one frame, and the jump to it stays the last
            self._jump = 0.0
        self._stamp = stamp
        return dt

    def _time_of_slow(self, stamp: int) -> float:
        """Time step [s] of a jump that is the time between frames; 0 of other ones."""
        before, self._jump = self._jump, 0.0
        passed = (stamp - self.now) / NANOSECONDS
        if not (self._follows and 0 < passed <= LONGEST_JUMP):
            return 0.0
        self._jump = passed
        return passed if passed <= MOST_STRETCH * before else 0.0

    def tell_restart(self) -> str:
        """Why the tracker restarted; empty if it did not, or if this has been asked before."""
        why, self.restarted = self.restarted, ''
        return why
