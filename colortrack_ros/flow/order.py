"""Puts messages into the order of their stamps."""

from collections.abc import Callable
from dataclasses import dataclass
import heapq
import time
from typing import Generic
from typing import TypeVar

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter

Item = TypeVar('Item')

IDLE = 0.1
"""Interval [s] at which waiting messages are checked. Assumed: it matters only when the input has
stopped, and then a message waits that much longer than it has to."""
MAX_ITEMS = 1000
"""Maximum number of waiting items: half a minute at 30 Hz, three times the longest
reorder_window."""
MAX_BYTES = 256 * 1024**2
"""Maximum memory of waiting pictures [bytes]: a sixteenth of the 4 GiB of a small robot's computer,
290 pictures of 640x480."""


@dataclass(frozen=True)
class OrderConfig(Config):
    """How long messages wait for earlier ones, and when they are too late."""

    reorder_window: float = parameter(
        0.0,
        'How long a message waits, by the stamps, for earlier ones that are still on their way.',
        unit='s',
        limits=(0.0, 10.0),
        audience=EXPERT,
    )
    max_late: float = parameter(
        0.25,
        'A message up to this much older than the last one is late and is dropped; if it is older '
        'still, time has gone back, as in a loop.',
        unit='s',
        limits=(0.0, 10.0),
        audience=EXPERT,
    )


class Order(Generic[Item]):
    """Releases items in the order of their stamps, and refuses those that come too late.

    :param release: takes each item when it is due.
    :param refuse: takes the reason why an item is dropped.
    :param clock: the time [s] at which items arrive: the node's clock, so that pausing a bag or
        playing it slowly changes nothing.
    :ivar window: parameter reorder_window [s].
    :ivar max_late: parameter max_late [s].
    """

    def __init__(
        self,
        release: Callable[[Item], object],
        refuse: Callable[[str], object],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.window = self.max_late = 0.0
        self._release, self._refuse, self._clock = release, refuse, clock
        self._arrived = clock()
        self._waiting: list[tuple[int, int, Item, int]] = []
        self._bytes = 0
        self._number = 0
        self._last = self._newest = -(1 << 62)  # older than any stamp

    def configure(self, config: OrderConfig) -> None:
        """Apply other values."""
        self.window, self.max_late = config.reorder_window, config.max_late

    def push(self, stamp: int, item: Item, size: int = 0) -> None:
        """Add an item that has just arrived.

        If too many wait, or take too much memory, the oldest are released before the window has
        passed.

        :param stamp: of its header [ns].
        :param size: the memory that it takes [bytes].
        """
        self._arrived = self._clock()
        behind = (self._newest - stamp) / NANOSECONDS
        if behind > self.window + self.max_late:
            self.flush()  # time has gone back: what waits was before that
            self._newest = self._last = stamp
        if stamp < self._last:
            self._refuse(
                f'stamp {stamp / NANOSECONDS:.3f} s is {behind:.3f} s older than the newest: late '
                'by no more than max_late, so it is dropped; reorder_window would wait for it'
            )
            return
        self._newest = max(self._newest, stamp)
        self._number += 1
        heapq.heappush(self._waiting, (stamp, self._number, item, size))
        self._bytes += size
        self._release_until(self._newest - round(self.window * NANOSECONDS))
        while len(self._waiting) > MAX_ITEMS or self._bytes > MAX_BYTES:
            self._release_oldest()

    def look(self, over: Callable[[], bool] = lambda: False) -> None:
        """Release all items if none has arrived for as long as the window.

        :param over: whether the input has ended.
        """
        # The clock has gone back: it belongs to another playback, and the old one has ended.
        if self._waiting and (abs(self._clock() - self._arrived) > self.window or over()):
            self.flush()

    def flush(self) -> None:
        """Release all items: the input has ended."""
        self._release_until(self._newest)

    def _release_until(self, stamp: int) -> None:
        while self._waiting and self._waiting[0][0] <= stamp:
            self._release_oldest()

    def _release_oldest(self) -> None:
        self._last, _, item, size = heapq.heappop(self._waiting)
        self._bytes -= size
        self._release(item)
