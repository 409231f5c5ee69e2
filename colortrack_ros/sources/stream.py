"""Network cameras."""

import re

import cv2

from colortrack_ros.sources.base import SourceError
from colortrack_ros.sources.capture import LiveCapture
from colortrack_ros.sources.capture import Now

TIMEOUT_MS = 5000
"""Timeout for the connection, and for the next picture [ms]: longer than the time between two key
frames of typical cameras."""

SCHEMES = ('rtsp://', 'rtsps://', 'http://', 'https://')
"""URL schemes of streams."""


class StreamSource(LiveCapture):
    """A stream, given by URL, `rtsp://user:password@host/path` or `http://host/stream.mjpg`.

    :raises SourceError: if no stream answers in time; the message does not contain the password.
    """

    def __init__(self, spec: str, rate: float, clock: Now) -> None:
        timeouts = [
            cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, TIMEOUT_MS, cv2.CAP_PROP_READ_TIMEOUT_MSEC, TIMEOUT_MS,
        ]  # fmt: skip
        capture = cv2.VideoCapture(spec, cv2.CAP_FFMPEG, timeouts)
        label = f'source {without_secrets(spec)!r}: the stream'
        if not capture.isOpened():
            raise SourceError(
                f'{label} gives no video (waited {TIMEOUT_MS / 1000:g} s at most); check the '
                'address, the password, and that the camera is on'
            )
        super().__init__(capture, label, clock)

    @staticmethod
    def accepts(spec: str) -> bool:
        """Accept a URL with a streaming scheme."""
        return spec.lower().startswith(SCHEMES)


def without_secrets(address: str) -> str:
    """Return the URL with *** for the password, and for the query, which may contain a key.

    Anything that is not a URL, such as `scene:five?rate=60`, is returned as it is.
    """
    if '://' not in address:
        return address
    return re.sub(r'\?.*', '?***', re.sub(r'(://[^:/@]*):.*@', r'\1:***@', address))
