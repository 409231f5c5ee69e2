"""Reads a source in a separate thread."""

from collections import deque
from collections.abc import Callable
import threading

from colortrack_ros.data import Frame
from colortrack_ros.sources.base import Source
from colortrack_ros.sources.base import SourceError

READ_AHEAD = 2
"""Number of frames of a recording to read ahead: one is decoded while another waits."""

CLOSE_TIMEOUT = 1.0
"""How long to wait on close for a read that does not return [s]: less than the 1.5 s that a node
has for its shutdown."""


class Grabber:
    """Delivers the newest frame of a live source, and every frame of a recording.

    A live source is read as fast as it delivers, so its own buffer never holds an old frame. If a
    frame has not been taken when the next one arrives, it is skipped and counted.

    :param source: closed together with the grabber.
    :param loop: whether to restart a recording, called at its end.
    """

    def __init__(self, source: Source, loop: Callable[[], bool] = lambda: False) -> None:
        self.live = source.live
        self.skipped = 0
        self._source, self._loop = source, loop
        self._items: deque[Frame | SourceError | None] = deque()
        self._changed = threading.Condition()
        self._closed = False
        self._failed = 0
        self._thread = threading.Thread(target=self._grab, name='grabber', daemon=True)
        self._thread.start()

    def read(self) -> Frame | None:
        """The next frame; None if the recording has ended or the grabber is closed.

        :raises SourceError: if a live source has failed, for good, or if a picture of a recording
            is unreadable; the next call then returns the picture after it. Any other exception of
            the source ends it, and is raised as a SourceError.
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
        """Unreadable pictures of a recording, so far."""
        return self._source.lost + self._failed

    def close(self) -> None:
        """Stop the thread, which closes the source."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._thread.join(CLOSE_TIMEOUT)

    def _is_last(self, item: Frame | SourceError | None) -> bool:
        """Whether all later calls return this item too: the end, or a failure of a live source."""
        return item is None or (self.live and isinstance(item, SourceError))

    def _grab(self) -> None:
        try:
            self._read_all()
        except Exception as error:  # otherwise the reader would wait forever
            self._failed = 1
            self._put(SourceError(f'the source has failed: {type(error).__name__}: {error}'))
            if not self.live:
                self._put(None)
        finally:
            self._source.close()

    def _read_all(self) -> None:
        rewound = True  # a recording without frames ends even when looping
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
