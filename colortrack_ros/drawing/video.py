"""Writes pictures to disk, one by one or as a video."""

import errno
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.files import require_file
from colortrack_ros.files import require_utf8
from colortrack_ros.files import write_file


class VideoFile:
    """An MPEG-4 video. :meth:`close` checks that it is complete, since OpenCV reports no errors.

    :param path: ends in .mp4.
    :param rate: frames a second [Hz].
    :param size: width and height of all pictures [px].
    :raises OSError: no video can be written there.
    """

    def __init__(self, path: Path, rate: float, size: tuple[int, int]) -> None:
        self._path, self._size, self._count = path, size, 0
        try:
            require_utf8(path)
        except UnicodeError as error:
            raise OSError(errno.EINVAL, str(error), str(path)) from error
        if path.exists():
            require_file(path)
        self._writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*'mp4v'), rate, size)
        if not self._writer.isOpened():
            reason = 'no video can be written there; expected an .mp4'
            raise OSError(errno.EINVAL, reason, str(path))

    def write(self, image: NDArray[np.uint8]) -> None:
        """Add a picture in bgr8, scaled to the size of the video if necessary."""
        if image.shape[1::-1] != self._size:
            image = np.asarray(cv2.resize(image, self._size), np.uint8)
        self._writer.write(image)
        self._count += 1

    def close(self) -> None:
        """Finish the file, and count the frames in it.

        :raises OSError: some are missing.
        """
        self._writer.release()
        written = cv2.VideoCapture(str(self._path), cv2.CAP_FFMPEG)
        count = max(int(written.get(cv2.CAP_PROP_FRAME_COUNT)), 0) if written.isOpened() else 0
        written.release()
        if count < self._count:
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
