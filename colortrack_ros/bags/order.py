"""Messages in the order of their stamps."""

from collections.abc import Iterator
import heapq
import itertools
from typing import Generic
from typing import TypeVar

Item = TypeVar('Item')


class StampOrder(Generic[Item]):
    """Holds each item for a while, so that one which comes a little later can go before it.

    Where two items have the same stamp, the one that came first is the one. When the stamps go far
    back, as in the recording of a loop, the order starts anew there.

    :param window: so much later than its place [ns] an item may come; what is later is dropped.
    :param restart: a jump back by more than this [ns], and more than the window, is a new start.
    :ivar late: number of items dropped because their place was gone.
    :ivar duplicates: number of items dropped because their stamp was there already.
    """

    def __init__(self, window: int, restart: int) -> None:
        self.late = self.duplicates = 0
        self._window, self._restart = window, max(restart, window)
        self._waiting: list[tuple[int, int, Item]] = []
        self._arrival = itertools.count()
        self._newest: int | None = None
        self._last: int | None = None

    def put(self, stamp: int, item: Item) -> Iterator[Item]:
        """Take an item, and give out those whose turn it is.

        :param stamp: of the item [ns].
        """
        if self._newest is not None and stamp < self._newest - self._restart:
            yield from self.rest()
            self._newest = self._last = None
        if self._last is not None and stamp <= self._last:
            self.duplicates += stamp == self._last
            self.late += stamp < self._last
            return
        heapq.heappush(self._waiting, (stamp, next(self._arrival), item))
        self._newest = stamp if self._newest is None else max(self._newest, stamp)
        yield from self._due(self._newest - self._window)

    def rest(self) -> Iterator[Item]:
        """Give out all that waits: nothing comes any more."""
        yield from self._due(self._newest)

    def _due(self, until: int | None) -> Iterator[Item]:
        while until is not None and self._waiting and self._waiting[0][0] <= until:
            stamp, _, item = heapq.heappop(self._waiting)
            if stamp == self._last:
                self.duplicates += 1
                continue
            self._last = stamp
            yield item
