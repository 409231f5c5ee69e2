"""Playing a recording in time."""

from collections.abc import Callable
import time

TOLERANCE = 1.0
"""A delay [s] beyond which the schedule is given up and starts again from now."""


class Pacer:
    """Returns from :meth:`pace` once a period, on a schedule that small delays do not shift.

    :param sleep: waits for so many seconds.
    :param clock: monotonic time [s].
    """

    def __init__(
        self, sleep: Callable[[float], object], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._sleep = sleep
        self._clock = clock
        self._due = -float('inf')

    def pace(self, period: float) -> None:
        """Wait until a period [s] after the time that the last call waited for."""
        now = self._clock()
        self._due += period
        if self._due < now - TOLERANCE:
            self._due = now
        elif self._due > now:
            self._sleep(self._due - now)
