"""Items that wait until what belongs to them is known."""

from collections import deque
from collections.abc import Callable
import threading
import time
from typing import Any
from typing import Generic
from typing import TypeVar

Item = TypeVar('Item')

MOST_INCOMPLETE = 1000
"""Items that may wait, where time stands still: half a minute at 30 Hz."""


class Completion(Generic[Item]):
    """Hands items on complete, in the order in which they came.

    :param complete: gives the complete item, or None if it has to wait; the second argument says
        that it must not wait any longer.
    :param hand_on: takes each complete item, and its context.
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

        :param context: whatever goes with it.
        """
        with self._lock:
            self._waiting.append((item, context, self._clock()))
            self._release(over=len(self._waiting) > MOST_INCOMPLETE)

    def look(self) -> None:
        """Hand on what is complete by now, and what has waited too long as it is."""
        with self._lock:
            self._release()

    def flush(self) -> None:
        """Hand on all that waits: nothing more comes."""
        with self._lock:
            while self._waiting:
                self._release(over=True)

    def _release(self, *, over: bool = False) -> None:
        """Hand on until one has to wait; over: the first must not."""
        while self._waiting:
            item, context, arrived = self._waiting[0]
            # a clock that has gone back is another one: nothing comes any more
            over = over or not 0 <= self._clock() - arrived <= self._longest
            complete = self._complete(item, over)
            if complete is None:
                return
            self._waiting.popleft()
            self._hand_on(complete, context)
            over = False
