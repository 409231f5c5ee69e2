"""Messages in the order of their stamps, whatever the order in which they arrive."""

from collections.abc import Callable
import heapq
import itertools
from typing import Generic
from typing import TypeVar

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.nodes.parameters import Spec

Item = TypeVar('Item')

ORDER = (
    Spec(
        'reorder_window',
        0.0,
        'Messages wait so long, by their stamps, for others that belong before them.',
        unit='s',
        minimum=0.0,
        maximum=10.0,
    ),
    Spec(
        'max_late',
        0.25,
        'A message older than the last one by no more than this is late and dropped; by more, '
        'time has gone back, as in a loop.',
        unit='s',
        minimum=0.0,
        maximum=10.0,
    ),
)
"""The rows of these two in a parameter table."""


class Order(Generic[Item]):
    """Releases items in the order of their stamps, and refuses those that come too late.

    :param release: takes an item whose turn it is.
    :param refuse: takes the reason why an item is dropped.
    """

    def __init__(self, release: Callable[[Item], object], refuse: Callable[[str], object]) -> None:
        self.window = self.max_late = 0.0
        self._release, self._refuse = release, refuse
        self._waiting: list[tuple[int, int, Item]] = []
        self._number = itertools.count()
        self._last = self._newest = -(1 << 62)  # older than any stamp

    def push(self, stamp: int, item: Item) -> None:
        """Take the next item that has arrived.

        :param stamp: of its header [ns].
        """
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
        heapq.heappush(self._waiting, (stamp, next(self._number), item))
        self._release_until(self._newest - round(self.window * NANOSECONDS))

    def flush(self) -> None:
        """Release all that wait: nothing else comes for a while."""
        self._release_until(self._newest)

    def _release_until(self, stamp: int) -> None:
        while self._waiting and self._waiting[0][0] <= stamp:
            self._last, _, item = heapq.heappop(self._waiting)
            self._release(item)
