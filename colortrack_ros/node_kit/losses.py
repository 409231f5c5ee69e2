"""Notices messages that were sent and did not come."""

from collections.abc import Callable

MOST_LOST = 0.1
"""Share of a period's messages whose loss is told. Assumed: trackers bridge single ones. Of 240
pictures of 640x480 132 were lost where the sender had the default shared memory of Fast DDS."""

HINT = (
    'give the process that sends them params/fastdds.xml, see "Pictures between processes" in '
    'doc/nodes.md, a deeper image_queue_depth, or this machine less to do'
)
"""What helps against it."""


class Losses:
    """Counts gaps in the sequence numbers of a topic's publisher.

    :ivar total: messages that did not come since the start.
    """

    def __init__(self) -> None:
        self.total = 0
        self._last: int | None = None
        self._came = self._lost = 0

    def see(self, number: int | None, is_alone: Callable[[], bool]) -> None:
        """Take the sequence number of the next message; None if the middleware has none.

        One that is not above the last one is of a new publisher.

        :param is_alone: whether one node publishes there; numbers of several take turns.
        """
        last, self._last = self._last, number
        self._came += 1
        missing = 0 if last is None or number is None else number - last - 1
        if missing > 0 and is_alone():
            self._lost += missing
            self.total += missing

    def tell(self) -> str:
        """Return what is wrong since the last call; empty if nothing is."""
        came, lost, self._came, self._lost = self._came, self._lost, 0, 0
        if lost <= MOST_LOST * (came + lost):
            return ''
        return f'{lost} of {came + lost} pictures were lost on their way to this node: {HINT}'
