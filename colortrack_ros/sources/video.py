"""Video files."""

from pathlib import Path

import cv2

from colortrack_ros.data import Frame
from colortrack_ros.sources.base import DEFAULT_RATE
from colortrack_ros.sources.base import RecordedSource
from colortrack_ros.sources.base import SourceError
from colortrack_ros.sources.capture import Clock


class VideoSource(RecordedSource):
    """A video file, of any format that FFmpeg reads; its own frame rate counts.

    :param rate: frames a second where the file does not say; 0: DEFAULT_RATE [Hz].
    :raises SourceError: when there is no such file, or no picture can be read from it.
    """

    def __init__(self, spec: str, rate: float, clock: Clock) -> None:
        if not Path(spec).is_file():
            raise SourceError(
                f'source {spec!r}: there is no such file; a source is a device (0 or /dev/video0), '
                'a video file, an rtsp:// or http:// stream, a folder or pattern of pictures, or '
                'scene:NAME'
            )
        self._path = spec
        self._capture = cv2.VideoCapture(spec, cv2.CAP_FFMPEG)
        own_rate = self._capture.get(cv2.CAP_PROP_FPS)
        if not self._capture.grab():
            raise SourceError(
                f'source {spec!r}: no video can be read from this file; expected mp4, mkv, avi, '
                'mov or another format of FFmpeg'
            )
        self.rewind()
        super().__init__(own_rate if own_rate > 0 else rate or DEFAULT_RATE)

    @staticmethod
    def accepts(spec: str) -> bool:
        """Anything: what is no other kind of source should be a file."""
        return True

    def read(self) -> Frame | None:
        """Return the next picture of the video."""
        decoded, image = self._capture.read()
        return self._frame(image) if decoded else None

    def rewind(self) -> None:
        """Open the file afresh: seeking is not exact in every format."""
        self._capture.release()
        self._capture = cv2.VideoCapture(self._path, cv2.CAP_FFMPEG)

    def close(self) -> None:
        """Let go of the file."""
        self._capture.release()
