"""The queue between the threads that deliver items and the thread that processes them."""

from collections import deque
import threading
from typing import Any
from typing import Generic
from typing import TypeVar

from colortrack_ros.flow.order import MAX_BYTES
from colortrack_ros.flow.order import MAX_ITEMS

Arrival = TypeVar('Arrival')
Item = TypeVar('Item')

LAST_COSTS = 20
"""Number of recent costs that predict the next one: two thirds of a second at 30 Hz, so that a
change of load shows soon."""
FEWEST_COSTS = 5
"""Number of costs needed for a prediction: the first items cost more, since tables are computed for
them."""
OUTLIERS = 4
"""The largest of every four costs is ignored: a hiccup of the machine is not an overload."""


class Costs:
    """Recent processing times of one step [s]."""

    def __init__(self) -> None:
        self._last: deque[float] = deque(maxlen=LAST_COSTS)

    def add(self, seconds: float) -> None:
        """Add the cost of one item."""
        self._last.append(seconds)

    @property
    def expected(self) -> float:
        """Their mean without outliers [s]; 0 while there are fewer than FEWEST_COSTS."""
        if len(self._last) < FEWEST_COSTS:
            return 0.0
        usual = sorted(self._last)[: -(len(self._last) // OUTLIERS)]
        return sum(usual) / len(usual)


class Backlog(Generic[Arrival, Item]):
    """Arrivals that have not been read yet, and items that are due, each in order.

    After a short delay the worker catches up without loss. When the backlog would take longer than
    ``max_lag`` to process, or takes too much memory, each arrival drops the oldest: a worker that
    is too slow then always gets the newest item, and the delay does not grow.

    :ivar max_lag: longest time [s] that processing the backlog may take.
    :ivar skipped: number of items skipped so far.
    :ivar reading: time to read an arrival, refused or not.
    :ivar working: time to process an item.
    """

    def __init__(self, max_lag: float = 0.0) -> None:
        self.max_lag = max_lag
        self.skipped = 0
        self.closed = False
        self.reading, self.working = Costs(), Costs()
        self._arrivals: deque[tuple[Arrival, int]] = deque()
        self._ready: deque[tuple[Item, int]] = deque()
        self._bytes = self._unfinished = 0
        self._changed = threading.Condition()

    def put(self, arrival: Arrival, size: int = 0) -> None:
        """Add an arrival, and skip the oldest ones that there is no time or memory for.

        :param size: the memory that it takes [bytes].
        """
        with self._changed:
            self._add(self._arrivals, arrival, size)
            while self._is_too_long():
                self._pop(self._ready or self._arrivals)
                self._unfinished -= 1
                self.skipped += 1

    def release(self, item: Item, size: int = 0) -> None:
        """Add an item that is due; it is older than all arrivals."""
        with self._changed:
            self._add(self._ready, item, size)

    def next_arrival(self, timeout: float) -> Arrival | None:
        """Remove and return the oldest arrival.

        :param timeout: return None when nothing arrives for this long [s], and at once while items
            are ready or when the backlog is closed.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._arrivals or self._ready or self.closed, timeout)
            return self._pop(self._arrivals) if self._arrivals and not self.closed else None

    def next_ready(self) -> Item | None:
        """Remove and return the oldest item that is due; None if there is none."""
        with self._changed:
            return self._pop(self._ready) if self._ready and not self.closed else None

    def done(self) -> None:
        """Mark the arrival or item that was last removed as done."""
        with self._changed:
            self._unfinished -= 1
            self._changed.notify_all()

    def join(self) -> None:
        """Wait until everything is done, or the backlog is closed."""
        with self._changed:
            self._changed.wait_for(lambda: self._unfinished == 0 or self.closed)

    def close(self) -> None:
        """Wake everything that waits."""
        with self._changed:
            self.closed = True
            self._changed.notify_all()

    def _add(self, lane: deque, item: Arrival | Item, size: int) -> None:
        lane.append((item, size))
        self._bytes += size
        self._unfinished += 1
        self._changed.notify_all()

    def _pop(self, lane: deque) -> Any:
        item, size = lane.popleft()
        self._bytes -= size
        return item

    def _is_too_long(self) -> bool:
        count = len(self._arrivals) + len(self._ready)
        seconds = count * (self.reading.expected + self.working.expected)
        too_much = count > MAX_ITEMS or self._bytes > MAX_BYTES
        return count > 1 and (too_much or seconds > self.max_lag)
