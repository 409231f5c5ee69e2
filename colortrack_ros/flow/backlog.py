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

    :ivar max_lag: how long [s] working off what waits may take.
    :ivar skipped: how many items have been.
    """

    def __init__(self, max_lag: float = 0.0) -> None:
        self.max_lag = max_lag
        self.skipped = 0
        self.closed = False
        self._items: deque[Item] = deque()
        self._ready = threading.Condition()
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

    def get(self, timeout: float | None = None) -> Item | None:
        """The oldest item that is left, once there is one; None when closed.

        :param timeout: return None when none has come for so long [s].
        """
        with self._ready:
            self._ready.wait_for(lambda: self._items or self.closed, timeout)
            return self._items.popleft() if self._items and not self.closed else None

    def took(self, seconds: float) -> None:
        """Tell how long the work on an item took."""
        with self._ready:
            self._costs.append(seconds)

    def close(self) -> None:
        """End the waiting in :meth:`get`."""
        with self._ready:
            self.closed = True
            self._ready.notify_all()
