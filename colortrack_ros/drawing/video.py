"""Writes pictures to disk, one by one or as a video."""

import errno
import math
import os
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.files import require_file
from colortrack_ros.files import require_utf8
from colortrack_ros.files import resolved
from colortrack_ros.files import write_file

MOST_TICKS = 65535
"""Most ticks that MPEG-4 counts of a second: vop_time_increment_resolution has 16 bits (ISO/IEC
14496-2, 6.2.3)."""


class VideoFile:
    """An MPEG-4 video, in its place once it is complete: :meth:`close` checks that, since OpenCV
    reports no errors. One that is not closed leaves what was there.

    :param path: ends in .mp4.
    :param rate: frames a second [Hz]; rounded to what MPEG-4 can tell; 0 for a single picture.
    :param size: width and height of all pictures [px].
    :raises OSError: no video can be written there.
    """

    def __init__(self, path: Path, rate: float, size: tuple[int, int]) -> None:
        self._path, self._size, self._count = path, size, 0
        try:
            require_utf8(path)
        except UnicodeError as error:
            raise OSError(errno.EINVAL, str(error), str(path)) from error
        self._target = resolved(path)
        if path.exists():
            require_file(path)
        try:
            self._folder = TemporaryDirectory(prefix='.video-', dir=self._target.parent)
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(path)) from error
        self._staged = str(Path(self._folder.name) / path.name)
        rate = min(rate or 1.0, MOST_TICKS)
        rate = round(rate, int(math.log10(MOST_TICKS / rate)))
        self._writer = cv2.VideoWriter(self._staged, cv2.VideoWriter.fourcc(*'mp4v'), rate, size)
        if not self._writer.isOpened():
            self._folder.cleanup()
            reason = f'no video of {size[0]}x{size[1]} px can be written; expected an .mp4'
            raise OSError(errno.EINVAL, reason, str(path))

    def write(self, image: NDArray[np.uint8]) -> None:
        """Add a picture in bgr8, scaled to the size of the video if necessary."""
        if image.shape[1::-1] != self._size:
            image = np.asarray(cv2.resize(image, self._size), np.uint8)
        self._writer.write(image)
        self._count += 1

    def close(self) -> None:
        """Finish the file, count the frames in it, and move it to its place.

        :raises OSError: some are missing; nothing is left of it.
        """
        self._writer.release()
        written = cv2.VideoCapture(self._staged, cv2.CAP_FFMPEG)
        count = max(int(written.get(cv2.CAP_PROP_FRAME_COUNT)), 0) if written.isOpened() else 0
        written.release()
        with self._folder:
            if count >= self._count:
                os.replace(self._staged, self._target)
                return
            reason = f'{count} of {self._count} frames have been written; is the disk full?'
            raise OSError(errno.ENOSPC, reason, str(self._path))


def write_picture(path: Path, image: NDArray[np.uint8]) -> None:
    """Write a picture in bgr8, in the format of the file's suffix.

    :raises OSError: it cannot be written.
    """
    try:
        write_file(path, cv2.imencode(path.suffix, image)[1].tobytes())
    except cv2.error as error:
        reason = 'expected the name of a picture, such as .png'
        raise OSError(errno.EINVAL, reason, str(path)) from error
