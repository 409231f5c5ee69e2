"""Holds items back until they can be completed."""

from collections import deque
from collections.abc import Callable
import threading
import time
from typing import Any
from typing import Generic
from typing import TypeVar

Item = TypeVar('Item')

MOST_INCOMPLETE = 1000
"""How many items may wait if the clock stands still: half a minute at 30 Hz."""


class Completion(Generic[Item]):
    """Passes items on in their order of arrival once they are complete.

    :param complete: returns the complete item, or None if it has to wait; the second argument says
        that it must not wait any longer.
    :param hand_on: takes each complete item and its context.
    :param longest: how long an item waits [s].
    :param clock: the time [s] at which items arrive.
    """

    def __init__(
        self,
        complete: Callable[[Item, bool], Item | None],
        hand_on: Callable[[Item, Any], object],
        longest: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._complete, self._hand_on = complete, hand_on
        self._longest, self._clock = longest, clock
        self._lock = threading.RLock()
        self._waiting: deque[tuple[Item, Any, float]] = deque()

    def put(self, item: Item, context: Any = None) -> None:
        """Take the next item.

        :param context: passed on with it.
        """
        with self._lock:
            self._waiting.append((item, context, self._clock()))
            self._release(over=len(self._waiting) > MOST_INCOMPLETE)

    def look(self) -> None:
        """Pass on items that are complete by now, and those that have waited too long, as they
        are.
        """
        with self._lock:
            self._release()

    def flush(self) -> None:
        """Pass on all waiting items; the input has ended."""
        with self._lock:
            while self._waiting:
                self._release(over=True)

    def _release(self, *, over: bool = False) -> None:
        """Pass items on until one has to wait; over: the first must not wait."""
        while self._waiting:
            item, context, arrived = self._waiting[0]
            # the clock has gone back, so it is another playback and nothing more will come
            over = over or not 0 <= self._clock() - arrived <= self._longest
            complete = self._complete(item, over)
            if complete is None:
                return
            self._waiting.popleft()
            self._hand_on(complete, context)
            over = False
