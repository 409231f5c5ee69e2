"""The live source of a camera node, which is opened again and again until it is there."""

from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import wait
import contextlib
import threading

from colortrack_ros.sources import Grabber
from colortrack_ros.sources import SourceError
from colortrack_ros.sources.device import AbsentSource
from colortrack_ros.sources.device import DeviceSource
from colortrack_ros.sources.stream import StreamSource

PAUSES = (0.5, 1.0, 2.0, 5.0)
"""Pauses [s] before a failed live source is reopened, growing with repeated failures. The last one
repeats: a user still waits that long."""
LOOKED_FOR_END = 0.05
"""Interval [s] at which the end of the node is looked for while a source opens, far less than what
a node has for its shutdown."""


def open_first(spec: str, opened: Callable[[], Grabber]) -> Grabber:
    """Open a source; a device or a network camera that is not there is waited for.

    :raises SourceError: any other source cannot be opened.
    """
    try:
        return opened()
    except SourceError as error:
        if not (DeviceSource.accepts(spec) or StreamSource.accepts(spec)):
            raise
        return Grabber(AbsentSource(error))


class Reopening:
    """Opens a live source that has failed, after pauses that grow until it works.

    Each pause is logged while they grow, later failures are counted alone.

    :param opened: opens it, which may take seconds.
    :param tell: logs an error.
    :param closing: set when the node ends.
    :ivar failures: how often it has failed since it last worked.
    """

    def __init__(
        self,
        opened: Callable[[], Grabber],
        tell: Callable[[str], object],
        closing: threading.Event,
    ) -> None:
        self._opened, self._tell, self._closing = opened, tell, closing
        self.failures = 0

    def again(self, error: SourceError) -> Grabber | None:
        """Wait, and open the source; None if it fails again, or the node ends."""
        pause = PAUSES[min(self.failures, len(PAUSES) - 1)]
        if self.failures < len(PAUSES):
            last = '' if pause < PAUSES[-1] else ' It is tried again and again, and counted.'
            self._tell(f'{str(error).rstrip(".")}. Next try in {pause:g} s.{last}')
        self.failures += 1
        self._closing.wait(pause)
        return self._open()

    def _open(self) -> Grabber | None:
        """Open it in a thread, which is abandoned when the node ends."""
        if self._closing.is_set():
            return None
        opening: Future[Grabber] = Future()

        def find() -> None:
            try:
                opening.set_result(self._opened())
            except Exception as error:  # _open raises it
                opening.set_exception(error)
            if self._closing.is_set():
                _discard(opening)

        threading.Thread(target=find, name='opening', daemon=True).start()
        while not wait([opening], LOOKED_FOR_END).done and not self._closing.is_set():
            pass
        if self._closing.is_set():
            _discard(opening)
            return None
        # if this fails, the next read from the old one fails, and leads here again
        with contextlib.suppress(SourceError):
            return opening.result()
        return None


def _discard(opening: Future[Grabber]) -> None:
    """Close what has been opened too late."""
    if opening.done() and opening.exception() is None:
        opening.result().close()
