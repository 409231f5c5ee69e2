"""Pairs pictures with their detections."""

from collections import deque
from collections.abc import Callable
import threading
from typing import Any
from typing import NamedTuple

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame

MAX_UNPAIRED = 30
"""How many pictures may wait by default: the depth of a subscription's queue."""


class Pair(NamedTuple):
    """A picture and its detections; None if the detector has skipped it."""

    frame: Frame
    detections: Detections | None

    @property
    def stamp(self) -> int:
        """Of the picture [ns]."""
        return self.frame.stamp

    @property
    def image(self) -> Any:
        """The picture itself."""
        return self.frame.image


class Pairing:
    """Pairs pictures with the detections of the same stamp, whichever arrive first.

    A detector may skip pictures but processes them in order: once the detections of a later picture
    have arrived, the earlier ones are passed on without. What counts is the order of arrival, not
    the stamps, so a recording may loop. Pictures and detections may come from two threads.

    :param hand_on: takes each pair, in the order of the pictures, and the context of its picture.
    :param most: how many pictures may wait, so that a detector that has ended blocks nothing.
    """

    def __init__(self, hand_on: Callable[[Pair, Any], object], most: int = MAX_UNPAIRED) -> None:
        self._hand_on, self._most = hand_on, most
        self._lock = threading.Lock()
        self._frames: deque[tuple[Frame, Any]] = deque()
        self._detections: deque[Detections] = deque(maxlen=most)

    def put_frame(self, frame: Frame, context: Any = None) -> None:
        """Take a picture."""
        with self._lock:
            self._frames.append((frame, context))
            known = any(found.stamp == frame.stamp for found in self._detections)
            self._release(len(self._frames) - (0 if known else self._most))

    def put_detections(self, detections: Detections, _: Any = None) -> None:
        """Take detections."""
        with self._lock:
            self._detections.append(detections)
            stamps = [frame.stamp for frame, _ in self._frames]
            found = detections.stamp in stamps
            self._release(stamps.index(detections.stamp) + 1 if found else 0)

    def _release(self, count: int) -> None:
        for _ in range(count):
            frame, context = self._frames.popleft()
            self._hand_on(Pair(frame, self._take(frame.stamp)), context)

    def _take(self, stamp: int) -> Detections | None:
        """The first detections of a stamp; in a looping recording there may be two."""
        for k, detections in enumerate(self._detections):
            if detections.stamp == stamp:
                del self._detections[k]
                return detections
        return None
