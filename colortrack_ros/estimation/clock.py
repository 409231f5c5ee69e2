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


class Clock:
    """A tracker's clock: the stamp of its last frame, and why it last restarted.

    :ivar restarted: the reason, until :meth:`tell_restart` returns it; empty if there is none.
    """

    def __init__(self) -> None:
        self._stamp: int | None = None
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
            reset(why)
        self._stamp = stamp
        return dt

    def tell_restart(self) -> str:
        """Why the tracker restarted; empty if it did not, or if this has been asked before."""
        why, self.restarted = self.restarted, ''
        return why
