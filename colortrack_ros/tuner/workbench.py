"""Runs the chain over a recording that users play, stop, scrub and tune."""

import time

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.chain import ColorChain
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.data import Tracks
from colortrack_ros.detection import Detector
from colortrack_ros.drawing import Trails
from colortrack_ros.flow.stage import Stage
from colortrack_ros.tracking import Tracker
from colortrack_ros.tuner.footage import Footage
from colortrack_ros.tuner.settings import Settings
from colortrack_ros.tuner.view import Picture
from colortrack_ros.tuner.view import ShownFrame
from colortrack_ros.tuner.view import trails_of

WARM_UP = 240
"""Number of frames before the current one from which its tracks and the background come: 8 s at 30
Hz, longer than the tracker remembers a lost object by default."""

WORK_SECONDS = 0.002
"""Time slice of non-urgent work [s], after which no further frame is begun: a click or a slider
waits for the end of one frame of 640x480, or for this long and a small one. Handing over to the
next slice takes 0.1 ms."""


class Workbench:
    """Plays the frames of a recording through detector and tracker.

    Only one thread at a time may use it. After :meth:`seek`, and after changes of the settings
    while stopped, :attr:`view` has the detections immediately, and the tracks once :meth:`catch_up`
    has returned False.

    :param footage: the recording.
    :param settings: of detector and tracker.
    :ivar view: of the current frame; None if the recording has no frames.
    :ivar playing: whether :meth:`step` is to be called repeatedly.
    """

    def __init__(self, footage: Footage, settings: Settings) -> None:
        self.footage, self.settings = footage, settings
        self._behind = self._stale = False
        self.playing = footage.live
        self.view: ShownFrame | None = None
        self._picture = Picture(Frame(np.zeros((0, 0, 3), np.uint8)))
        self._restart(0)
        self._advance(0)

    def play(self) -> None:
        """Play from here, a camera from now; at the end of a recording, from the beginning."""
        self._finish()
        if not self.footage.live and self.view and self.view.number >= self.footage.last:
            self._restart(0)
            self._advance(0)
        self.playing = True

    def pause(self) -> None:
        """Stop at this frame."""
        self.playing = False

    def step(self) -> bool:
        """Go to the next frame, or a camera's newest; stop at the end of a recording.

        :returns: whether there is one.
        """
        self._finish()
        newest = self.footage.last if self.footage.live else self._next
        if newest >= self._next and self._advance(newest):
            return True
        self.playing = self.playing and self.footage.live
        return False

    def seek(self, number: int) -> None:
        """Go to a frame, or the nearest one available."""
        self.playing = False
        number = max(number, self.footage.first)  # read once: a camera drops frames meanwhile
        frame = self.footage.frame(number)
        if frame is None:
            number = self.footage.last
            frame = self.footage.frame(number)
        if frame is not None:
            self._look(number, frame)

    def configure(self) -> None:
        """Apply the settings."""
        self._detector.configure(self.settings.detector)
        self._tracker.configure(self.settings.tracker)
        if not self.playing and self.view:
            self._look(self.view.number, self.view.frame)

    def learn_background(self) -> None:
        """Forget the background; it is learned anew from the next frame on."""
        self._detector.learn_background()

    def background(self) -> tuple[NDArray, NDArray] | None:
        """See :meth:`Detector.background`, for the current frame.

        :returns: None also while earlier frames are still to be processed.
        """
        return None if self._behind or not self.view else self._detector.background(self._frame)

    def catch_up(self, seconds: float = WORK_SECONDS) -> bool:
        """Work toward the tracks of the current frame, for at most that long.

        :returns: whether there is more to do.
        """
        if not self._behind or self.view is None:
            return False
        current = self.view.number
        if self._stale:
            self._restart(min(max(current - WARM_UP, self.footage.first), current))
        end = time.monotonic() + seconds
        while self._next <= current:
            if time.monotonic() > end:
                return True
            # A camera's frames are not kept forever, but the one that is shown is.
            is_shown = self._next == current
            frame = self.view.frame if is_shown else self.footage.frame(self._next)
            self._next += 1
            if frame is not None:
                self._take(frame)
        self._behind = False
        self._show()
        return False

    def _finish(self) -> None:
        while self.catch_up(1.0):
            pass

    def _restart(self, number: int) -> None:
        """Start a new chain at a frame."""
        self._detector = Detector(self.settings.detector)
        self._tracker = Tracker(self.settings.tracker)
        self._trails = Trails()
        self._next = number
        self._stale = False
        detection: Stage[Frame, Detections] = Stage(self._detector.detect, str)
        tracking: Stage[Detections, Tracks] = Stage(self._tracker.update, str)
        self._chain = ColorChain(detection, tracking)
        detection.then(self._take_detections)
        tracking.then(self._take_tracks)

    def _look(self, number: int, frame: Frame) -> None:
        """Show the detections of a frame as the detector now finds them; its tracks come later."""
        self._tracks: Tracks | None = None
        start = time.monotonic()
        self._detections = self._detector.detect(frame)
        self._seconds = time.monotonic() - start
        self._frame = frame
        self._show(number)
        self._behind = self._stale = True

    def _advance(self, number: int) -> bool:
        frame = self.footage.frame(number)
        if frame is None:
            return False
        self._next = number + 1
        self._take(frame)
        self._show()
        return True

    def _take(self, frame: Frame) -> None:
        start = time.monotonic()
        self._chain.put(frame)
        self._seconds = time.monotonic() - start
        self._frame = frame

    def _show(self, number: int | None = None) -> None:
        if self._picture.frame is not self._frame:
            self._picture = Picture(self._frame)
        self.view = ShownFrame(
            self._next - 1 if number is None else number,
            self._picture,
            np.array(self._detector.labels),
            self._detections,
            self._tracks,
            {} if self._tracks is None else trails_of(self._trails),
            self._seconds * 1e3,
            self._detector.trouble,
            self.settings.revision,
        )

    def _take_detections(self, detections: Detections, _: object) -> None:
        self._detections = detections

    def _take_tracks(self, tracks: Tracks, _: object) -> None:
        self._tracks = tracks
        self._trails.update(tracks)
