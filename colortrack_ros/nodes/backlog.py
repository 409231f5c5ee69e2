"""What waits to be worked on between a subscription and the thread that works."""

from collections import deque
import threading
from typing import Generic
from typing import TypeVar

Item = TypeVar('Item')


COSTS = 5
"""So many of the last items tell how long the work on one takes."""


class Backlog(Generic[Item]):
    """Items in their order, of which the oldest are skipped when working on all takes too long.

    A short delay is caught up with nothing lost; a worker that is slower than what arrives gets
    the newest item each time, not a growing delay.

    :param max_lag: how long [s] working off what waits may take.
    """

    def __init__(self, max_lag: float) -> None:
        self.max_lag = max_lag
        self.skipped = 0
        self._items: deque[Item] = deque()
        self._ready = threading.Condition()
        self._closed = False
        self._costs: deque[float] = deque(maxlen=COSTS)

    def put(self, item: Item) -> None:
        """Add the newest item."""
        with self._ready:
            self._items.append(item)
            # The least of several: a single slow one, as the first, says nothing of the others.
            cost = min(self._costs) if len(self._costs) == COSTS else 0.0
            while len(self._items) > 1 and len(self._items) * cost > self.max_lag:
                self._items.popleft()
                self.skipped += 1
            self._ready.notify()

    def get(self) -> Item | None:
        """The oldest item that is left, once there is one; None when closed."""
        with self._ready:
            self._ready.wait_for(lambda: self._items or self._closed)
            return None if self._closed else self._items.popleft()

    def took(self, seconds: float) -> None:
        """Tell how long the work on an item took."""
        with self._ready:
            self._costs.append(seconds)

    def close(self) -> None:
        """End the waiting in :meth:`get`."""
        with self._ready:
            self._closed = True
            self._ready.notify_all()
