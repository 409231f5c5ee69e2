"""Pictures that wait for what has been detected in them."""

from collections import deque

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame

WAITING = 30
"""Pictures that wait at most: a detector that has ended stops nobody."""

Pair = tuple[Frame, Detections | None]


class Pairing:
    """Brings pictures and detections of the same stamp together, whichever come first.

    A detector may skip pictures, but works on them in their order: a picture goes on without
    detections once there are those of a picture that came after it. Which stamp is greater does not
    count, so a recording may loop.
    """

    def __init__(self) -> None:
        self._frames: deque[Frame] = deque()
        self._detections: dict[int, Detections] = {}

    def put_frame(self, frame: Frame) -> list[Pair]:
        """Take a picture; return the pairs that are ready, in their order."""
        self._frames.append(frame)
        if frame.stamp in self._detections:
            return self._release(len(self._frames))
        return self._release(len(self._frames) - WAITING)

    def put_detections(self, detections: Detections) -> list[Pair]:
        """Take detections; return the pairs that are ready, in their order."""
        self._detections[detections.stamp] = detections
        if len(self._detections) > WAITING:
            self._detections.pop(next(iter(self._detections)))
        stamps = [frame.stamp for frame in self._frames]
        found = detections.stamp in stamps
        return self._release(stamps.index(detections.stamp) + 1 if found else 0)

    def _release(self, count: int) -> list[Pair]:
        frames = [self._frames.popleft() for _ in range(count)]
        return [(frame, self._detections.pop(frame.stamp, None)) for frame in frames]
