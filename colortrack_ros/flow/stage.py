"""The stages of the chain: items are put in order, processed one at a time, and passed on."""

from collections.abc import Callable
import threading
import time
from typing import Any
from typing import Generic
from typing import Protocol
from typing import TypeVar

from colortrack_ros.flow.backlog import Backlog
from colortrack_ros.flow.faults import fault_of
from colortrack_ros.flow.order import IDLE
from colortrack_ros.flow.order import Order
from colortrack_ros.flow.order import OrderConfig


class Stamped(Protocol):
    """Anything that has the stamp of a frame."""

    @property
    def stamp(self) -> int:
        """Time of the exposure [ns]."""


In = TypeVar('In', bound=Stamped)
Out = TypeVar('Out')
Taker = Callable[[Any, Any], object]
Unread = tuple[Callable[[], In], Any]


class Stage(Generic[In, Out]):
    """Processes items in the order of their stamps, in the thread that puts them in.

    :param work: computes the result of an item.
    :param refuse: takes the reason why an item is dropped.
    :param clock: the time [s] at which items arrive; see :class:`Order`.
    :ivar paused: whether what arrives is dropped unread.
    """

    def __init__(
        self,
        work: Callable[[In], Out],
        refuse: Callable[[str], object],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.paused = False
        self._make, self._refuse = work, refuse
        self._takers: list[Taker] = []
        self._lock = threading.RLock()
        self._order: Order[tuple[In, Any]] = Order(self._release, refuse, clock)

    def __getstate__(self) -> dict[str, Any]:
        """All but the lock, for copies and other processes."""
        return {name: value for name, value in vars(self).items() if name != '_lock'}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._lock = threading.RLock()

    @property
    def skipped(self) -> int:
        """Number of items skipped: none here, since the caller waits."""
        return 0

    def configure(self, config: OrderConfig) -> None:
        """Apply other values."""
        self._order.configure(config)

    def then(self, taker: Taker) -> None:
        """Pass each result, with the context of its item, to this function as well."""
        self._takers.append(taker)

    def hand_on(self, result: Out, context: Any = None) -> None:
        """Pass a result, which may have been made elsewhere, to all that take it."""
        for taker in self._takers:
            taker(result, context)

    def put(self, item: In, context: Any = None) -> None:
        """Take the next item that has arrived.

        :param context: passed on with its result.
        """
        if not self.paused:
            self._push(item, context)

    def _push(self, item: In, context: Any) -> None:
        with self._lock:
            self._order.push(item.stamp, (item, context), _size_of(item))

    def look(self, over: Callable[[], bool] = lambda: False) -> None:
        """Process the waiting items if none has arrived for as long as the window; see Order."""
        with self._lock:
            self._order.look(over)

    def settle(self) -> None:
        """Wait until all is worked on whose turn it is."""

    def flush(self) -> None:
        """Work on all that waits: nothing more comes."""
        with self._lock:
            self._order.flush()

    def close(self) -> None:
        """End what runs."""

    def _release(self, entry: tuple[In, Any]) -> None:
        self._work_on(*entry)

    def _work_on(self, item: In, context: Any) -> None:
        self.hand_on(self._make(item), context)


class Worker(Stage[In, Out]):
    """A stage with a thread of its own, which skips the oldest items when it is too slow.

    If the work on an item raises any exception, only that item is refused.

    :param over: whether the input has ended; see :meth:`Order.look`.
    :param name: of the thread.
    """

    def __init__(
        self,
        work: Callable[[In], Out],
        refuse: Callable[[str], object],
        clock: Callable[[], float] = time.monotonic,
        over: Callable[[], bool] = lambda: False,
        name: str = 'worker',
    ) -> None:
        super().__init__(work, refuse, clock)
        self._over = over
        self._backlog: Backlog[Unread[In], tuple[In, Any]] = Backlog()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._start = threading.Lock()

    @property
    def skipped(self) -> int:
        """Number of items skipped."""
        return self._backlog.skipped

    @property
    def max_lag(self) -> float:
        """How long [s] processing the backlog may take."""
        return self._backlog.max_lag

    @max_lag.setter
    def max_lag(self, seconds: float) -> None:
        self._backlog.max_lag = seconds

    def put(self, item: In, context: Any = None) -> None:
        """Take the next item that has arrived."""
        self.put_unread(lambda: item, _size_of(item), context)

    def put_unread(self, read: Callable[[], In], size: int, context: Any = None) -> None:
        """Take the next item, which the thread reads unless it is skipped.

        :param read: returns the item; raises ValueError with the reason if it is refused.
        :param size: the memory that it takes unread [bytes].
        """
        if self.paused:
            return
        with self._start:
            if self._thread.ident is None and not self._backlog.closed:
                self._thread.start()
        self._backlog.put((read, context), size)

    def settle(self) -> None:
        """Wait until all is worked on whose turn it is."""
        self._backlog.join()

    def flush(self) -> None:
        """Process everything that is waiting, and wait until that is done."""
        self.settle()
        super().flush()
        self.settle()

    def close(self) -> None:
        """End the thread."""
        self._backlog.close()
        if self._thread.is_alive():
            self._thread.join()

    def _release(self, entry: tuple[In, Any]) -> None:
        self._backlog.release(entry, _size_of(entry[0]))

    def _run(self) -> None:
        try:
            while not self._backlog.closed:
                self._step()
        finally:
            self._backlog.close()  # nobody must wait for a thread that has died

    def _step(self) -> None:
        """Read one arrival, and process one item that is due."""
        arrival = self._backlog.next_arrival(IDLE)
        if arrival is not None:
            self._read(*arrival)
        ready = self._backlog.next_ready()
        if ready is not None:
            start = time.monotonic()
            try:
                self._work_on(*ready)
            except Exception as error:  # of any kind
                self._refuse(fault_of(error))
            self._backlog.working.add(time.monotonic() - start)
            self._backlog.done()
        elif arrival is None:
            self.look(self._over)

    def _read(self, read: Callable[[], In], context: Any) -> None:
        start = time.monotonic()
        try:
            item = read()
            self._push(item, context)
        except ValueError as error:
            self._refuse(str(error))
        except Exception as error:
            self._refuse(fault_of(error))
        self._backlog.reading.add(time.monotonic() - start)
        self._backlog.done()


def _size_of(item: object) -> int:
    """Memory of a frame's picture [bytes]; everything else is negligible."""
    return int(getattr(getattr(item, 'image', None), 'nbytes', 0))
