"""Merges items of several sources in the order of their stamps."""

from collections.abc import Callable
import heapq
import itertools
import threading
import time
from typing import Generic
from typing import TypeVar

from colortrack_ros.data import NANOSECONDS

Item = TypeVar('Item')

LONGEST_SILENCE = 0.2
"""How long [s] the others wait for a source: two pictures at 10 Hz. Assumed: with half of it the
others go ahead whenever a picture is lost at 10 Hz; with twice as much, a dead source delays them
for longer."""


class Interleaving(Generic[Item]):
    """Merges the items of several sources, each of them in order.

    An item is passed on once every source has reached its stamp. A source that has been silent for
    longer than LONGEST_SILENCE is not waited for; items that it delivers too late are refused.

    :param count: number of sources. With one, every item is passed on at once.
    :param hand_on: takes each item.
    :param refuse: takes the reason why an item is dropped.
    :param clock: the time [s] at which items arrive.
    """

    def __init__(
        self,
        count: int,
        hand_on: Callable[[Item], object],
        refuse: Callable[[str], object],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._hand_on, self._refuse, self._clock = hand_on, refuse, clock
        self._stamps, self._arrived = [0] * count, [-LONGEST_SILENCE] * count
        self._waiting: list[tuple[int, int, Item]] = []
        self._numbers, self._last = itertools.count(), 0
        self._lock = threading.RLock()

    def put(self, source: int, stamp: int, item: Item) -> None:
        """Take the next item of a source.

        :param stamp: of its picture [ns].
        """
        with self._lock:
            if stamp < self._stamps[source]:  # time has gone back: these are from before
                self._release(1 << 62)
                self._stamps, self._last = [stamp] * len(self._stamps), stamp
            self._stamps[source], self._arrived[source] = stamp, self._clock()
            if stamp < self._last:
                self._refuse(
                    f'a picture that is {(self._last - stamp) / NANOSECONDS:.3f} s older than one '
                    'of another camera that has been processed: it came too late'
                )
                return
            heapq.heappush(self._waiting, (stamp, next(self._numbers), item))
            self.look()

    def look(self) -> None:
        """Pass on the items that no source can precede any more."""
        with self._lock:
            now = self._clock()
            awaited = [
                stamp
                for stamp, arrived in zip(self._stamps, self._arrived, strict=True)
                if 0 <= now - arrived <= LONGEST_SILENCE
            ]
            self._release(min(awaited, default=1 << 62))

    def _release(self, until: int) -> None:
        while self._waiting and self._waiting[0][0] <= until:
            self._last, _, item = heapq.heappop(self._waiting)
            self._hand_on(item)
