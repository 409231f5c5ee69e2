"""Reads a source in a thread of its own."""

from collections import deque
from collections.abc import Callable
import threading

from colortrack_ros.data import Frame
from colortrack_ros.sources.base import Source
from colortrack_ros.sources.base import SourceError

READ_AHEAD = 2
"""Frames of a recording that are read ahead: one is decoded while one waits."""

CLOSE_TIMEOUT = 1.0
"""How long closing waits for a read that does not return [s]: less than the 1.5 s in which a node
has to end."""


class Grabber:
    """Gives the newest frame of a live source, and every frame of a recording.

    A live source is read as fast as it goes, so that its own buffer never holds an old frame; a
    frame that nobody has taken is skipped and counted when the next one comes.

    :param source: is closed with the grabber.
    :param loop: whether a recording that has ended starts again, asked at its end.
    """

    def __init__(self, source: Source, loop: Callable[[], bool] = lambda: False) -> None:
        self.live, self.period = source.live, source.period
        self.skipped = 0
        self._source, self._loop = source, loop
        self._items: deque[Frame | SourceError | None] = deque()
        self._changed = threading.Condition()
        self._closed = False
        self._failed = 0
        self._thread = threading.Thread(target=self._grab, name='grabber', daemon=True)
        self._thread.start()

    def read(self) -> Frame | None:
        """The next frame; None when the recording has ended or the grabber is closed.

        :raises SourceError: a live source has failed, for good; or a picture of a recording is
            unreadable, and the next call gives the one after it. Any other exception of the source
            ends it, and comes as a SourceError.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._items or self._closed)
            if self._closed:
                return None
            item = self._items[0]
            if not self._is_last(item):
                self._items.popleft()
                self._changed.notify_all()
        if isinstance(item, SourceError):
            raise item
        return item

    @property
    def lost(self) -> int:
        """Pictures of a recording that could not be read, so far."""
        return self._source.lost + self._failed

    def close(self) -> None:
        """End the thread, which closes the source."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._thread.join(CLOSE_TIMEOUT)

    def _is_last(self, item: Frame | SourceError | None) -> bool:
        """Whether this is the answer to all later calls as well: the end, or a failure."""
        return item is None or (self.live and isinstance(item, SourceError))

    def _grab(self) -> None:
        try:
            self._read_all()
        except Exception as error:  # or a reader would wait for ever
            self._failed = 1
            self._put(SourceError(f'the source has failed: {type(error).__name__}: {error}'))
            if not self.live:
                self._put(None)
        finally:
            self._source.close()

    def _read_all(self) -> None:
        rewound = True  # a recording without frames ends, also in a loop
        while not self._closed:
            item: Frame | SourceError | None
            try:
                item = self._source.read()
            except SourceError as error:
                item = error
            if item is None and not rewound and self._loop():
                self._source.rewind()
                rewound = True
                continue
            rewound = rewound and not isinstance(item, Frame)
            self._put(item)
            if self._is_last(item):
                break

    def _put(self, item: Frame | SourceError | None) -> None:
        with self._changed:
            if self.live:
                self.skipped += len(self._items)
                self._items.clear()
            self._changed.wait_for(lambda: len(self._items) < READ_AHEAD or self._closed)
            self._items.append(item)
            self._changed.notify_all()
