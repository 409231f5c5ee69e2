"""Cameras of this machine."""

import glob
from pathlib import Path
from typing import NoReturn

import cv2

from colortrack_ros.sources.base import Source
from colortrack_ros.sources.base import SourceError
from colortrack_ros.sources.capture import Clock
from colortrack_ros.sources.capture import LiveCapture


class AbsentSource(Source):
    """A device that is not there yet: reading it fails as opening it did.

    :param error: what opening it raised.
    """

    live = True
    period = 0

    def __init__(self, error: SourceError) -> None:
        self._error = error

    @staticmethod
    def accepts(spec: str) -> bool:
        """Nothing: it stands in for a device."""
        return False

    def read(self) -> NoReturn:
        """Raise the error."""
        raise self._error

    def rewind(self) -> None:
        """There is nothing to go back to."""

    def close(self) -> None:
        """Nothing is held open."""


class DeviceSource(LiveCapture):
    """A camera by its number or path, `0` or `/dev/video0`.

    :param rate: frames a second to ask the device for; 0: what it gives [Hz].
    :raises SourceError: when there is no such device, or it gives no pictures.
    """

    def __init__(self, spec: str, rate: float, clock: Clock) -> None:
        path = f'/dev/video{spec}' if spec.isdecimal() else spec
        there = ', '.join(sorted(glob.glob('/dev/video*'))) or 'no /dev/video*'
        if not Path(path).exists():
            raise SourceError(f'source {spec!r}: there is no device {path}; there is {there}')
        capture = cv2.VideoCapture(path, cv2.CAP_V4L2)
        if not capture.isOpened():
            raise SourceError(
                f'source {spec!r}: {path} cannot be opened as a camera (in use by another program, '
                f'or no permission?); there is {there}'
            )
        if rate > 0:
            capture.set(cv2.CAP_PROP_FPS, rate)
        super().__init__(capture, f'source {spec!r}: the device', clock)

    @staticmethod
    def accepts(spec: str) -> bool:
        """A number or a path below /dev."""
        return spec.isdecimal() or spec.startswith('/dev/')
