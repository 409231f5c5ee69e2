"""Cameras on the network."""

import re

import cv2

from colortrack_ros.sources.base import SourceError
from colortrack_ros.sources.capture import LiveCapture
from colortrack_ros.sources.capture import Now

TIMEOUT_MS = 5000
"""How long to wait for a connection, and for the next picture [ms]: more than the seconds between
two key frames of a usual camera."""

SCHEMES = ('rtsp://', 'rtsps://', 'http://', 'https://')
"""Schemes of the addresses of streams."""


class StreamSource(LiveCapture):
    """A stream by its address, `rtsp://user:password@host/path` or `http://host/stream.mjpg`.

    :raises SourceError: when no stream answers there in time; the password is not in the message.
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
        """An address of a scheme for streams."""
        return spec.lower().startswith(SCHEMES)


def without_secrets(address: str) -> str:
    """Return the address with *** for the password and the query, which may hold a key.

    What is no address, such as `scene:five?rate=60`, stays as it is.
    """
    if '://' not in address:
        return address
    return re.sub(r'\?.*', '?***', re.sub(r'(://[^:/@]*):.*@', r'\1:***@', address))
