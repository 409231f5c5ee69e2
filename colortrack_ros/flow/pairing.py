"""Pictures that wait for what has been detected in them."""

from collections import deque
from typing import Generic
from typing import Protocol
from typing import TypeVar

from colortrack_ros.data import Detections


class Stamped(Protocol):
    """A Frame, or what stands for one."""

    @property
    def stamp(self) -> int: ...  # noqa: D102


Picture = TypeVar('Picture', bound=Stamped)

WAITING = 30
"""Pictures that wait at most: a detector that has ended stops nobody."""


class Pairing(Generic[Picture]):
    """Brings pictures and detections of the same stamp together, whichever come first.

    A detector may skip pictures, but works on them in their order: a picture goes on without
    detections once there are those of a picture that came after it. Which stamp is greater does not
    count, so a recording may loop.
    """

    def __init__(self) -> None:
        self._frames: deque[Picture] = deque()
        self._detections: dict[int, Detections] = {}

    def put_frame(self, frame: Picture) -> list[tuple[Picture, Detections | None]]:
        """Take a picture; return the pairs that are ready, in their order."""
        self._frames.append(frame)
        if frame.stamp in self._detections:
            return self._release(len(self._frames))
        return self._release(len(self._frames) - WAITING)

    def put_detections(self, detections: Detections) -> list[tuple[Picture, Detections | None]]:
        """Take detections; return the pairs that are ready, in their order."""
        self._detections[detections.stamp] = detections
        if len(self._detections) > WAITING:
            self._detections.pop(next(iter(self._detections)))
        stamps = [frame.stamp for frame in self._frames]
        found = detections.stamp in stamps
        return self._release(stamps.index(detections.stamp) + 1 if found else 0)

    def _release(self, count: int) -> list[tuple[Picture, Detections | None]]:
        frames = [self._frames.popleft() for _ in range(count)]
        return [(frame, self._detections.pop(frame.stamp, None)) for frame in frames]
