"""Pictures that wait for what has been detected in them."""

from collections import deque

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame

WAITING = 30
"""Pictures that wait at most: a detector that has ended stops nobody."""

Pair = tuple[Frame, Detections | None]


class Pairing:
    """Brings pictures and detections of the same stamp together, in whatever order they come.

    A picture goes on once detections of its stamp or a later one are there: a detector may skip
    pictures, but works on them in their order.
    """

    def __init__(self) -> None:
        self._frames: deque[Frame] = deque()
        self._detections: deque[Detections] = deque(maxlen=WAITING)

    def put_frame(self, frame: Frame) -> list[Pair]:
        """Take a picture; return the pairs that are ready, in their order."""
        self._frames.append(frame)
        return self._ready()

    def put_detections(self, detections: Detections) -> list[Pair]:
        """Take detections; return the pairs that are ready, in their order."""
        self._detections.append(detections)
        return self._ready()

    def _ready(self) -> list[Pair]:
        pairs = []
        newest = self._detections[-1].stamp if self._detections else None
        while self._frames:
            stamp = self._frames[0].stamp
            if (newest is None or stamp > newest) and len(self._frames) <= WAITING:
                break
            mine = next((d for d in self._detections if d.stamp == stamp), None)
            pairs.append((self._frames.popleft(), mine))
        return pairs
