"""Messages in the order of their stamps, whatever the order in which they arrive."""

from collections.abc import Callable
from dataclasses import dataclass
import heapq
import itertools
import time
from typing import Generic
from typing import TypeVar

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter

Item = TypeVar('Item')

IDLE = 0.1
"""Period [s] of the check whether messages have waited long enough."""
MAX_ITEMS = 1000
"""Most items that may wait: half a minute at 30 Hz, three times the longest reorder_window."""
MAX_BYTES = 256 * 1024**2
"""Most memory that waiting pictures may take: a sixteenth of the 4 GiB of a small robot's computer,
290 pictures of 640x480."""


@dataclass(frozen=True)
class OrderConfig(Config):
    """Which messages wait for others, and which are too late."""

    reorder_window: float = parameter(
        0.0,
        'How long, by the stamps, a message waits for earlier ones that are still on their way.',
        unit='s',
        minimum=0.0,
        maximum=10.0,
        audience=EXPERT,
    )
    max_late: float = parameter(
        0.25,
        'A message older than the last one by no more than this is late and dropped; by more, '
        'time has gone back, as in a loop.',
        unit='s',
        minimum=0.0,
        maximum=10.0,
        audience=EXPERT,
    )


class Order(Generic[Item]):
    """Releases items in the order of their stamps and refuses those that come too late.

    :param release: takes an item whose turn it is.
    :param refuse: takes the reason why an item is dropped.
    :param clock: the time [s] at which items arrive: the node's, so that a bag that is paused or
        played slowly has all the time it needs.
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
        self._number = itertools.count()
        self._last = self._newest = -(1 << 62)  # older than any stamp

    def configure(self, config: OrderConfig) -> None:
        """Take other values into use."""
        self.window, self.max_late = config.reorder_window, config.max_late

    def push(self, stamp: int, item: Item, size: int = 0) -> None:
        """Add an item that has just arrived.

        When too many wait, or take too much memory, the oldest go before the window has passed.

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
        heapq.heappush(self._waiting, (stamp, next(self._number), item, size))
        self._bytes += size
        self._release_until(self._newest - round(self.window * NANOSECONDS))
        while len(self._waiting) > MAX_ITEMS or self._bytes > MAX_BYTES:
            self._release_oldest()

    def look(self, over: Callable[[], bool] = lambda: False) -> None:
        """Release all items if none has arrived for the length of the window.

        :param over: whether the input has ended.
        """
        # A clock that has gone back belongs to another playback: the old one has ended.
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
