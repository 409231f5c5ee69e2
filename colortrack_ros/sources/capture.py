"""cv2.VideoCapture, quiet, and with the time of the grab."""

from collections.abc import Callable
import os
from typing import Any

import cv2
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.sources.base import Source
from colortrack_ros.sources.base import SourceError

# The error that is raised says all; FFmpeg and OpenCV would write their own lines beside it,
# passwords of streams included. FFmpeg reads this when it is first used.
os.environ.setdefault('OPENCV_FFMPEG_LOGLEVEL', '-8')
_set_log_level = getattr(cv2, 'setLogLevel', None) or cv2.utils.logging.setLogLevel
_set_log_level(0)  # OpenCV 5 has moved it

Now = Callable[[], int]
"""Returns the time [ns]."""


class LiveCapture(Source):
    """A live capture, whose frames have the time of the grab.

    :param capture: opened.
    :param label: what to call it in an error.
    :param clock: returns the time [ns].
    """

    live = True
    period = 0

    def __init__(self, capture: cv2.VideoCapture, label: str, clock: Now) -> None:
        self._capture = capture
        self._label = label
        self._clock = clock

    def read(self) -> Frame:
        """Wait for the next frame; it is stamped before it is decoded."""
        grabbed = self._capture.grab()
        stamp = self._clock()
        image: Any = self._capture.retrieve()[1] if grabbed else None
        if image is None:
            raise SourceError(f'{self._label} has stopped giving pictures')
        return self._frame(image, stamp)

    def _frame(self, image: NDArray, stamp: int) -> Frame:
        return Frame(image, 'bgr8', stamp)

    def rewind(self) -> None:
        """A live source has no beginning."""

    def close(self) -> None:
        """Release the device or the connection."""
        self._capture.release()
