"""The interface of every source of frames."""

from abc import ABC
from abc import abstractmethod
from collections.abc import Iterator

from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS

DEFAULT_RATE = 30.0
"""Frame rate of a recording that gives none [Hz]: that of most cameras."""


class SourceError(Exception):
    """A source cannot be opened or has failed: one line, what was given and what would work."""


class Source(ABC):
    """Where frames come from. A frame owns its picture: nothing overwrites it later.

    A new kind is a class that has these methods, `accepts(spec)`, and a constructor of
    (spec, rate, clock), in a file of its own, and a line in SOURCES.

    :ivar live: frames come when they come, stamped with the clock; else a recording.
    :ivar period: time from frame to frame of a recording [ns]; 0 for live sources.
    :ivar lost: pictures of a recording that could not be read, so far.
    :ivar total: frames that a recording has according to itself; 0 where that is not known.
    """

    live: bool
    period: int
    lost: int = 0
    total: int = 0

    @staticmethod
    @abstractmethod
    def accepts(spec: str) -> bool:
        """Say whether the spec means a source of this kind."""

    @abstractmethod
    def read(self) -> Frame | None:
        """Return the next frame in bgr8, waiting for it if live; None at the end of a recording.

        :raises SourceError: when a live source fails, or one picture of a recording is unreadable;
            the next call reads the one after it.
        """

    def __iter__(self) -> Iterator[Frame]:
        """Every frame from the next one on; raises what :meth:`read` raises."""
        while (frame := self.read()) is not None:
            yield frame

    @abstractmethod
    def rewind(self) -> None:
        """Start a recording over; its stamps count on. A live source cannot."""

    @abstractmethod
    def close(self) -> None:
        """Release files and devices."""


class RecordedSource(Source):
    """A source that can be read again: frame k since opening has the stamp k / rate.

    :param rate: frames a second.
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
        """Return the frame of a time, counted in frames since opening."""
        self._count = int(time) + 1
        return Frame(image, 'bgr8', round(time * NANOSECONDS / self._rate))

    def close(self) -> None:
        """Nothing is held open."""
