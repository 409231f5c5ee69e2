"""How pictures become tracks: the stages, and how they are connected.

The nodes, ``pipeline``, ``replay``, and :class:`ColorTracker` all run the chains of this file. They
provide the stages, which run in the caller's thread (:class:`Stage`) or in their own
(:class:`Worker`), and receive the results of each through :meth:`Stage.then`.
"""

from typing import Any
from typing import NoReturn
from typing import Protocol
import warnings

import numpy as np

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.data import Tracks
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.encodings import check
from colortrack_ros.flow.pairing import MAX_UNPAIRED
from colortrack_ros.flow.pairing import Pair
from colortrack_ros.flow.pairing import Pairing
from colortrack_ros.flow.stage import Stage
from colortrack_ros.flow.stamps import StampWatch
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

BOX = ('box_u', 'box_v', 'box_w', 'box_h')


class DetectionsTaker(Protocol):
    """Takes detections and makes tracks: a stage, or an intake in front of one."""

    def put(self, item: Detections, context: Any = None) -> None:
        """Take the next detections."""

    def flush(self) -> None:
        """Process everything that is waiting; the input has ended."""


class ColorChain:
    """From frames to detections to tracks; each stage keeps its own order.

    :param detection: makes the detections of a frame.
    :param tracking: makes the tracks after detections.
    """

    def __init__(self, detection: Stage[Frame, Detections], tracking: DetectionsTaker) -> None:
        self._detection, self._tracking = detection, tracking
        detection.then(tracking.put)

    def put(self, item: Frame | Detections, context: Any = None) -> None:
        """Take the next frame, or its detections; the context is passed on through all stages."""
        if isinstance(item, Detections):
            self._detection.hand_on(item, context)
        else:
            self._detection.put(item, context)

    def settle(self) -> None:
        """Wait until every item that is due has been processed."""
        self._detection.settle()

    def flush(self) -> None:
        """Work on all items that still wait: the input has ended."""
        self._detection.flush()
        self._tracking.flush()


class ImageChain:
    """From frames to tracks, by a tracker of pictures; detections may start its targets.

    :param pictures: passes on each frame when it is due.
    :param tracking: makes the tracks after a pair.
    :param detects: whether frames wait for their detections.
    :param detection: makes them here; None if another node does, and :meth:`put` takes them.
    :param most: how many frames may wait for their detections.
    """

    def __init__(
        self,
        pictures: Stage[Frame, Frame],
        tracking: Stage[Pair, Tracks],
        *,
        detects: bool,
        detection: Stage[Frame, Detections] | None = None,
        most: int = MAX_UNPAIRED,
    ) -> None:
        self._pairing = Pairing(tracking.put, most)
        self._intakes: list[Stage[Frame, Any]] = [pictures, *([detection] if detection else [])]
        self._tracking = tracking
        if detects:
            pictures.then(self._pairing.put_frame)
        else:
            pictures.then(lambda frame, context: tracking.put(Pair(frame, None), context))
        if detection:
            detection.then(self._pairing.put_detections)

    def put(self, item: Frame | Detections, context: Any = None) -> None:
        """Take the next frame, or detections from another node."""
        if isinstance(item, Detections):
            self._pairing.put_detections(item)
            return
        for stage in self._intakes:
            stage.put(item, context)

    def flush(self) -> None:
        """Work on all items that still wait: the input has ended."""
        for stage in self._intakes:
            stage.flush()
        self._tracking.flush()


def track_pair(tracker: Any, pair: Pair) -> Tracks:
    """The tracks after a picture; its detections, if it has any, may start targets."""
    if pair.detections is not None:
        rows = pair.detections.rows
        tracker.offer(np.stack([rows[name] for name in BOX], axis=1))
    tracks: Tracks = tracker.update(pair.frame)
    return tracks


class ColorTracker:
    """Detector and tracker as one function: takes a frame and returns the tracks after it.

    Each camera needs its own, and only one thread at a time may use it.

    >>> from colortrack_ros.chain import ColorTracker
    >>> from colortrack_ros.sources import open_source
    >>> track = ColorTracker()
    >>> for frame in open_source('scene:single?width=320&height=240&duration=2'):
    ...     tracks = track(frame)
    >>> for row in tracks.rows:
    ...     print(f'track {row["track_id"]} at ({row["u"]:.0f}, {row["v"]:.0f})')
    track 1 at (78, 171)

    :param detector: what the detector looks for.
    :param tracker: how the tracker follows it.
    :ivar detections: of the last frame.
    :raises ValueError: one of them is something else.
    """

    def __init__(
        self, detector: DetectorConfig | None = None, tracker: TrackerConfig | None = None
    ) -> None:
        for given, kind in ((detector, DetectorConfig), (tracker, TrackerConfig)):
            if not isinstance(given, (kind, type(None))):
                raise ValueError(f'expected a {kind.__name__}, got a {type(given).__name__}')
        detection = Stage(Detector(detector or DetectorConfig()).detect, _refuse)
        tracking = Stage(Tracker(tracker or TrackerConfig()).update, _refuse)
        self._stamps = StampWatch()
        self._chain = ColorChain(detection, tracking)
        detection.then(self._take_detections)
        tracking.then(self._take_tracks)

    def __call__(self, frame: Frame) -> Tracks:
        """Take the next frame.

        If the stamp has gone back, as in a recording that loops, the tracker restarts; see
        ``Tracks.restarted``. If stamps stand still, it warns (UserWarning).

        :raises ValueError: this is no frame, or its encoding does not match its picture.
        """
        check(frame)
        if self._stamps.see(frame.stamp):
            warnings.warn(
                'the stamps stand still, so nothing moves: give each Frame its time [ns], '
                'Frame(picture, stamp=round(seconds * 1e9))',
                stacklevel=2,
            )
        self._chain.put(frame)
        return self._tracks

    def _take_detections(self, detections: Detections, _: object) -> None:
        self.detections = detections

    def _take_tracks(self, tracks: Tracks, _: object) -> None:
        self._tracks = tracks


def _refuse(reason: str) -> NoReturn:
    raise ValueError(reason)
