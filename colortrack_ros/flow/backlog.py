"""What waits to be worked on between those who hand it over and the thread that works."""

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
"""How many of the last costs tell what the next item will cost: at 30 Hz two thirds of a second, in
which a change of the load shows."""
FEWEST_COSTS = 5
"""With fewer nobody can tell: the first items cost more, since tables are computed for them."""
OUTLIERS = 4
"""One cost in so many, the greatest, is not counted: a hiccup of the machine is no overload."""


class Costs:
    """What one step of the work has cost lately, in seconds."""

    def __init__(self) -> None:
        self._last: deque[float] = deque(maxlen=LAST_COSTS)

    def add(self, seconds: float) -> None:
        """Take the cost of one more item."""
        self._last.append(seconds)

    @property
    def expected(self) -> float:
        """The mean without outliers [s]; 0 while nobody can tell."""
        if len(self._last) < FEWEST_COSTS:
            return 0.0
        usual = sorted(self._last)[: -(len(self._last) // OUTLIERS)]
        return sum(usual) / len(usual)


class Backlog(Generic[Arrival, Item]):
    """Arrivals that nobody has read yet, and items whose turn it is, in their order.

    A short delay is caught up with nothing lost. When working off all that waits would take longer
    than ``max_lag``, or takes too much memory, the oldest are skipped whenever something arrives: a
    worker that is too slow gets the newest each time, not a growing delay.

    :ivar max_lag: how long [s] working off what waits may take.
    :ivar skipped: how many have been skipped.
    :ivar reading: what reading an arrival costs, whether it is refused or not.
    :ivar working: what working on an item costs.
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
        """Add what has just arrived, and skip what has to be skipped for it.

        :param size: the memory that it takes [bytes].
        """
        with self._changed:
            self._add(self._arrivals, arrival, size)
            while self._is_too_long():
                self._pop(self._ready or self._arrivals)
                self._unfinished -= 1
                self.skipped += 1

    def release(self, item: Item, size: int = 0) -> None:
        """Add an item whose turn has come; it is older than whatever arrives."""
        with self._changed:
            self._add(self._ready, item, size)

    def next_arrival(self, timeout: float) -> Arrival | None:
        """The oldest arrival.

        :param timeout: return None when nothing arrives for this long [s]; None comes at once while
            items are ready, or once the backlog is closed.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._arrivals or self._ready or self.closed, timeout)
            return self._pop(self._arrivals) if self._arrivals and not self.closed else None

    def next_ready(self) -> Item | None:
        """The oldest item whose turn it is, None when there is none."""
        with self._changed:
            return self._pop(self._ready) if self._ready and not self.closed else None

    def done(self) -> None:
        """Tell that what was got last, an arrival or an item, has been dealt with."""
        with self._changed:
            self._unfinished -= 1
            self._changed.notify_all()

    def join(self) -> None:
        """Wait until everything has been dealt with, or the backlog is closed."""
        with self._changed:
            self._changed.wait_for(lambda: self._unfinished == 0 or self.closed)

    def close(self) -> None:
        """End all waiting."""
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
