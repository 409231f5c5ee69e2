"""The frames for the page, by number: any frame of a recording, and the last ones of a camera."""

from abc import ABC
from abc import abstractmethod
from collections import OrderedDict
from collections.abc import Callable
import threading

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.sources import Source
from colortrack_ros.sources import SourceError

KEPT_BYTES = 512 * 1024**2
"""Memory for pictures, so that stepping back is quick [bytes]: 580 of 640x480 or 190 of 1280x720;
an eighth of the 4 GiB of a small computer."""

POLL_RATE = 60.0
"""How often a camera is polled for a new frame [Hz]: the refresh rate of a screen."""


class KeptFrames(OrderedDict[int, Frame]):
    """Frames by their numbers, as many as fit; the oldest are dropped first."""

    _bytes = 0

    def add(self, number: int, frame: Frame) -> None:
        """Keep a frame, as the last one."""
        before = self.pop(number, None)
        self[number] = frame
        self._bytes += frame.image.nbytes - (before.image.nbytes if before else 0)
        while self._bytes > KEPT_BYTES and len(self) > 1:
            _, old = self.popitem(last=False)
            self._bytes -= old.image.nbytes


class Footage(ABC):
    """Frames with numbers from 0.

    :ivar label: its name for display.
    :ivar live: whether it is a camera, not a recording.
    :ivar rate: frames per second; for a camera, how often to poll it [Hz].
    :ivar first: number of the first available frame.
    :ivar total: number of the last frame plus one, as far as is known.
    :ivar trouble: why frames are missing; empty if none is, as far as is known.
    """

    label: str
    live: bool
    rate: float
    first: int = 0
    total: int = 0
    trouble: str = ''

    @abstractmethod
    def frame(self, number: int) -> Frame | None:
        """A frame; None if it does not exist, or is no longer available."""

    @abstractmethod
    def close(self) -> None:
        """Close files and devices."""

    @property
    def last(self) -> int:
        """Number of the last frame, as far as is known."""
        return max(self.total - 1, 0)


class RecordedFootage(Footage):
    """A recording.

    Frames are read in order and kept as long as they fit. To get one that was dropped, the
    recording is reopened, since the stamps of a rewound source would continue.

    :param open_it: opens the source of the frames, which is not live; frames that cannot be read
        are left out, and told in :attr:`trouble`.
    """

    live = False

    def __init__(self, label: str, open_it: Callable[[], Source]) -> None:
        self._open, self._source = open_it, open_it()
        self.label, self.total = label, self._source.total
        self.rate = NANOSECONDS / self._source.period
        self._kept = KeptFrames()
        self._next = 0

    def frame(self, number: int) -> Frame | None:
        """A frame; None after the end."""
        if number in self._kept:
            self._kept.move_to_end(number)
            return self._kept[number]
        if number < self._next:
            self._source.close()
            self._source = self._open()
            self._next = 0
        while self._next <= number:
            frame = self._read()
            if frame is None:
                self.total = self._next
                return None
            self._kept.add(self._next, frame)
            self._next += 1
        self.total = max(self.total, self._next)
        return self._kept[number]

    def open_again(self) -> Source:
        """Open the source of all frames, from the first one."""
        return self._open()

    def close(self) -> None:
        """Close the files."""
        self._source.close()

    def _read(self) -> Frame | None:
        while True:
            try:
                frame = self._source.read()
            except SourceError as error:
                self.trouble = str(error)
                continue
            return frame


class LiveFootage(Footage):
    """The last frames of a camera; any thread may add one."""

    live = True
    rate = POLL_RATE

    def __init__(self, label: str) -> None:
        self.label = label
        self._kept = KeptFrames()
        self._lock = threading.Lock()

    def put(self, frame: Frame) -> None:
        """Add the newest frame."""
        with self._lock:
            self._kept.add(self.total, frame)
            self.first = next(iter(self._kept))
            self.total += 1

    def frame(self, number: int) -> Frame | None:
        """A frame; None if it has not arrived yet, or has been dropped."""
        with self._lock:
            return self._kept.get(number)

    def close(self) -> None:
        """Nothing to do: the thread that adds frames has its own end."""


class CameraFootage(LiveFootage):
    """A device or a stream, read in a thread of its own.

    :param source: a live one, which is closed with this.
    """

    def __init__(self, label: str, source: Source) -> None:
        super().__init__(label)
        self._source, self._closed = source, False
        self._thread = threading.Thread(target=self._grab, name='camera', daemon=True)
        self._thread.start()

    def _grab(self) -> None:
        try:
            for frame in self._source:
                if self._closed:
                    break
                self.put(frame)
        except SourceError as error:
            self.label = f'{self.label}: {error}'
        finally:
            self._source.close()

    def close(self) -> None:
        """Stop the thread, after the next frame."""
        self._closed = True
