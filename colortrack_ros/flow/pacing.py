"""Plays a recording in real time, or as fast as it is consumed."""

from collections import deque
from collections.abc import Callable
import threading
import time

MAX_BEHIND = 1.0
"""Delay [s] beyond which the schedule restarts from now. Assumed: after a pause, at most 30 frames
at 30 Hz are sent in a hurry, and 15 or 60 with half or twice the value."""

ANSWER_TIMEOUT = 1.0
"""How long [s] a frame waits for its answer: if the detector has skipped it, none will come.
Assumed: even a detector at 1 Hz answers in time."""


class Pacer:
    """Lets :meth:`pace` return once a period, on a schedule that small delays do not shift.

    :param sleep: waits for a time [s].
    :param clock: monotonic time [s].
    """

    def __init__(
        self, sleep: Callable[[float], object], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._sleep = sleep
        self._clock = clock
        self._due = -float('inf')
        self._restarts = False

    def restart(self) -> None:
        """Begin a new schedule with the next call: the period has changed."""
        self._restarts = True

    def pace(self, period: float) -> None:
        """Wait until one period [s] after the scheduled time of the last call."""
        now = self._clock()
        self._due += period
        if self._restarts or self._due < now - MAX_BEHIND:
            self._due, self._restarts = now, False
        elif self._due > now:
            self._sleep(self._due - now)


class Window:
    """Limits the number of frames that have been sent but not answered.

    :param size: that limit.
    :param patience: time [s] after which no answer is expected any more.
    """

    def __init__(self, size: int, patience: float = ANSWER_TIMEOUT) -> None:
        self._size, self._patience = size, patience
        self._waiting: deque[int] = deque()
        self._changed = threading.Condition()

    def send(self, stamp: int) -> None:
        """Wait until there is room for one more frame, and count it.

        :param stamp: of the frame [ns].
        """
        with self._changed:
            room = self._changed.wait_for(lambda: len(self._waiting) < self._size, self._patience)
            if not room:
                self._waiting.clear()
            self._waiting.append(stamp)

    def drain(self) -> None:
        """Wait for the answers to all frames."""
        with self._changed:
            self._changed.wait_for(lambda: not self._waiting, self._patience)

    def answer(self, stamp: int) -> None:
        """Count a frame and all before it as consumed."""
        with self._changed:
            while self._waiting and self._waiting[0] <= stamp:
                self._waiting.popleft()
            self._changed.notify_all()
