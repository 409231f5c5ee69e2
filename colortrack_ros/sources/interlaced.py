"""Interlaced videos, whose pictures newer versions of OpenCV do not convert."""

import os
import subprocess
import sys

import numpy as np

from colortrack_ros.sources.capture import open_file

FIRST_PICTURES = 3
"""Number of first pictures that are the same to the last bit where none after the first was
converted. Assumed: that is rare otherwise, such as in recordings of a screen, and then costs half a
second."""

TIME_TO_ASK = 5.0
"""Timeout for what FFmpeg says [s]. Assumed: half the time that a file has to be opened."""

READ_FIRST = f"""
import cv2, sys
capture = cv2.VideoCapture(sys.argv[1], cv2.CAP_FFMPEG)
for _ in range({FIRST_PICTURES}):
    capture.read()
"""

FFMPEG_ERRORS = {'OPENCV_FFMPEG_LOGLEVEL': '16'}
"""AV_LOG_ERROR of libavutil/log.h."""


def is_unconverted(path: str) -> bool:
    """Whether OpenCV returns memory that it has never written to instead of the pictures.

    With FFmpeg 8, as in the wheels of OpenCV 5, it does so if a picture is marked as interlaced,
    and reports success. Only FFmpeg's log tells. Its level is set once in a process, and this one's
    is quiet, so another process reads the pictures again.
    """
    capture = open_file(path)
    pictures = [image for read, image in (capture.read() for _ in range(FIRST_PICTURES)) if read]
    capture.release()
    if not pictures or not all(np.array_equal(pictures[0], other) for other in pictures[1:]):
        return False
    command = [sys.executable, '-c', READ_FIRST, os.path.abspath(path)]
    try:
        said = subprocess.run(
            command,
            cwd=os.sep,  # else it would import a cv2.py or queue.py of the current folder
            env=os.environ | FFMPEG_ERRORS,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=TIME_TO_ASK,
        ).stdout
    except (OSError, subprocess.TimeoutExpired):
        return False
    return b'interlaced' in said
