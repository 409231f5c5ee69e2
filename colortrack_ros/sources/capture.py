"""A quiet wrapper of cv2.VideoCapture that stamps frames when they are grabbed."""

from collections.abc import Callable
import os
from typing import Any

import cv2
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.sources.base import Source
from colortrack_ros.sources.base import SourceError

# The raised error says it all. FFmpeg and OpenCV would also print lines of their own, including
# the passwords of streams. FFmpeg reads this variable when it is first used.
os.environ.setdefault('OPENCV_FFMPEG_LOGLEVEL', '-8')
_set_log_level = getattr(cv2, 'setLogLevel', None) or cv2.utils.logging.setLogLevel
_set_log_level(0)  # moved in OpenCV 5

Now = Callable[[], int]
"""Returns the time [ns]."""


def open_file(path: str) -> cv2.VideoCapture:
    """Open a video file with FFmpeg, which takes the 12 of a relative 12:30.mp4 for a protocol."""
    return cv2.VideoCapture(os.path.abspath(path), cv2.CAP_FFMPEG)


class LiveCapture(Source):
    """A live capture whose frames are stamped when they are grabbed.

    :param capture: an open capture.
    :param label: name of the source in error messages.
    :param clock: returns the time [ns].
    """

    live = True
    period = 0

    def __init__(self, capture: cv2.VideoCapture, label: str, clock: Now) -> None:
        self._capture = capture
        self._label = label
        self._clock = clock

    def read(self) -> Frame:
        """Wait for the next frame; it is stamped before decoding."""
        grabbed = self._capture.grab()
        stamp = self._clock()
        image: Any = self._capture.retrieve()[1] if grabbed else None
        if image is None:
            raise SourceError(f'{self._label} has stopped giving pictures')
        return self._frame(image, stamp)

    def _frame(self, image: NDArray, stamp: int) -> Frame:
        return Frame(image, 'bgr8', stamp)

    def rewind(self) -> None:
        """Do nothing: a live source has no beginning."""

    def close(self) -> None:
        """Release the device or the connection."""
        self._capture.release()
