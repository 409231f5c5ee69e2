"""Folders of pictures."""

import glob
from pathlib import Path
import re

import cv2

from colortrack_ros.data import Frame
from colortrack_ros.picture_files import read_picture
from colortrack_ros.sources.base import DEFAULT_RATE
from colortrack_ros.sources.base import RecordedSource
from colortrack_ros.sources.base import SourceError
from colortrack_ros.sources.capture import Now

PICTURE_SUFFIXES = ('.png', '.jpg', '.jpeg', '.bmp', '.tif', '.tiff', '.webp', '.pgm', '.ppm')
"""Suffixes of the formats that OpenCV reads in both Debian's build and the wheels."""


class PicturesSource(RecordedSource):
    """The pictures in a folder, or matching a pattern such as `shots/*.png`, in natural order.

    9.png comes before 10.png.

    :param rate: frames per second; 0: DEFAULT_RATE [Hz].
    :raises SourceError: if there is no picture, or the first one is unreadable.
    """

    def __init__(self, spec: str, rate: float, clock: Now) -> None:
        super().__init__(rate if rate > 0 else DEFAULT_RATE)
        if Path(spec).is_file():
            found = [spec]
        else:
            found = glob.glob(f'{glob.escape(spec)}/*' if Path(spec).is_dir() else spec)
        # Reading a named pipe would block until its other end is opened.
        paths = [p for p in found if p.lower().endswith(PICTURE_SUFFIXES) and Path(p).is_file()]
        if not paths:
            raise SourceError(
                f'source {spec!r}: no pictures there; expected files that end in '
                f'{", ".join(PICTURE_SUFFIXES)}'
            )
        self._paths = sorted(paths, key=natural)
        self.total = len(paths)
        self._next = 0
        self.read()
        self.rewind()
        self._count = 0

    @staticmethod
    def accepts(spec: str) -> bool:
        """Accept a folder, a pattern, or a single picture."""
        if Path(spec).is_file() or not glob.has_magic(spec):
            return spec.lower().endswith(PICTURE_SUFFIXES) or (spec != '' and Path(spec).is_dir())
        return True

    def read(self) -> Frame | None:
        """Return the next picture."""
        if self._next == self.total:
            return None
        path = self._paths[self._next]
        self._next += 1
        try:
            return self._frame(read_picture(path, cv2.IMREAD_COLOR))
        except ValueError as error:
            self.lost += 1
            raise SourceError(f'picture {path!r} cannot be read: {error}') from error

    def rewind(self) -> None:
        """Go back to the first picture."""
        self._next = 0


def natural(path: str) -> list[str | int]:
    """Return a sort key that compares numbers within names by value."""
    return [int(part) if part.isdecimal() else part for part in re.split(r'(\d+)', path)]
