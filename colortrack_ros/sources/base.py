"""The interface of all frame sources."""

from abc import ABC
from abc import abstractmethod
from collections.abc import Iterator

from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS

DEFAULT_RATE = 30.0
"""Frame rate of a recording that does not specify one [Hz]: that of most cameras."""


class SourceError(Exception):
    """A source cannot be opened or has failed: one line with what was given and what would work."""


class Source(ABC):
    """A source of frames. Each frame owns its picture, which is never overwritten.

    To add a kind of source, write a class with these methods, `accepts(spec)`, and a constructor
    with (spec, rate, clock), in its own file, and add it to SOURCES.

    :ivar live: frames arrive in real time and are stamped with the clock; otherwise a recording.
    :ivar period: time between frames of a recording [ns]; 0 for live sources.
    :ivar lost: pictures of a recording that are unreadable, or were scaled, so far.
    :ivar total: number of frames that a recording claims to have; 0 if unknown.
    """

    live: bool
    period: int
    lost: int = 0
    total: int = 0

    @staticmethod
    @abstractmethod
    def accepts(spec: str) -> bool:
        """Return whether the spec is for this kind of source."""

    @abstractmethod
    def read(self) -> Frame | None:
        """Return the next frame in bgr8, waiting for it if live; None at the end of a recording.

        :raises SourceError: if a live source fails, or a picture of a recording is unreadable; the
            next call then reads the picture after it.
        """

    def __iter__(self) -> Iterator[Frame]:
        """Yield all remaining frames; raises what :meth:`read` raises."""
        while (frame := self.read()) is not None:
            yield frame

    @abstractmethod
    def rewind(self) -> None:
        """Restart a recording; its stamps keep increasing. A live source does nothing."""

    @abstractmethod
    def close(self) -> None:
        """Release files and devices."""


class RecordedSource(Source):
    """A source that can be replayed: frame k since opening has the stamp k / rate.

    :param rate: frames per second.
    """

    live = False

    def __init__(self, rate: float) -> None:
        self.period = round(NANOSECONDS / rate)
        self._rate = rate
        self._count = 0

    def _frame(self, image: NDArray) -> Frame:
        """Return the next frame, stamped."""
        return self._frame_at(self._count, image)

    def _frame_at(self, time: float, image: NDArray) -> Frame:
        """Return the frame at a time, in frames since opening."""
        self._count = int(time) + 1
        return Frame(image, 'bgr8', round(time * NANOSECONDS / self._rate))

    def close(self) -> None:
        """Do nothing: nothing is held open."""
