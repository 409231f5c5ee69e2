"""Video files."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.sources.avi import indexed_pictures
from colortrack_ros.sources.base import DEFAULT_RATE
from colortrack_ros.sources.base import RecordedSource
from colortrack_ros.sources.base import SourceError
from colortrack_ros.sources.capture import Now
from colortrack_ros.sources.capture import open_file
from colortrack_ros.sources.edit_list import shown_pictures
from colortrack_ros.sources.ends import is_cut_off
from colortrack_ros.sources.ends import last_picture
from colortrack_ros.sources.fragments import damaged_fragments
from colortrack_ros.sources.interlaced import is_unconverted
from colortrack_ros.sources.matroska import expected_pictures
from colortrack_ros.sources.mp4 import lacks_index
from colortrack_ros.sources.picture_size import Size
from colortrack_ros.sources.picture_size import SizeWatch

ROUNDING = 0.0005
"""Rounding of the times in a container [s]: Matroska has whole milliseconds, others are finer.
Times this close to a multiple of the period are set to the multiple."""

READ_ON = 250
"""Number of pictures to try after an unreadable one before giving up, or more if the container
promises more: ten seconds at 25 Hz. In the damaged mp4 of test/sources, reading resumes with 25 and
ends at the damage with 12. The value is ten times as large, since trying costs only time."""

LEAST_BYTES = 4
"""Assumed least size of a picture in a file [bytes]: a broken index may promise billions, each of
which would be tried. Sizes and times alone take more."""

ESTIMATE = 2
"""Number of pictures by which a container without damage may overstate its length, which may be
estimated from its duration. Measured: of 78 whole films at a constant rate, six codecs in seven
containers, FLV with reordered pictures does by 2, all others by 0."""

SAME_PERIOD = 0.1
"""Largest deviation of the time between two pictures from the period [share of the period]. Chosen:
at 100 Hz, rounding both times to milliseconds causes as much."""

CONSTANT_RATE = 0.9
"""Share of the pictures that come one period after their predecessor, from which the rate counts as
constant and gaps as losses. Assumed: it is 0.987 to 1 in ten videos with damage in the middle, and
at most 0.67 in eleven with a variable rate."""


CUTS = (4, 7) <= tuple(int(part) for part in cv2.__version__.split('.')[:2]) < (4, 13)
"""Whether OpenCV cuts pictures of another size, and reads beyond the memory of smaller ones. Tried:
4.10 to 4.12 do, 4.6 gives pictures as they are, 4.13 scales them."""


class VideoSource(RecordedSource):
    """A video file, in any format that FFmpeg reads, with its own frame rate and times.

    Reading continues after damage. Stamps are the container's times, so lost pictures leave a gap.
    In containers without times, such as AVI, they are k / rate. Pictures of another size than the
    first are scaled to it, told, and counted as lost.

    :param rate: frames per second if the file does not specify it; 0: DEFAULT_RATE [Hz].
    :raises SourceError: if there is no such file, or no picture can be read from it.
    """

    _held: Frame | None
    _first: int
    _given: int
    _missing: int
    _ended: bool
    _longest: float
    _timed: int
    _following: int
    _shape: tuple[int, ...]
    _sizes: SizeWatch
    _told: Size

    def __init__(self, spec: str, rate: float, clock: Now) -> None:
        if not Path(spec).is_file():
            raise SourceError(
                f'source {spec!r}: there is no such file; a source is a device (0 or /dev/video0), '
                'a video file, an rtsp:// or http:// stream, a folder or pattern of pictures, or '
                'scene:NAME'
            )
        self._path = spec
        self._capture = open_file(spec)
        own_rate = self._capture.get(cv2.CAP_PROP_FPS)
        total = max(int(self._capture.get(cv2.CAP_PROP_FRAME_COUNT)), 0)
        shown = shown_pictures(spec)
        self._most = Path(spec).stat().st_size // LEAST_BYTES
        self.total = total if shown is None else min(shown, total)
        self._estimated = shown is None
        if not any(self._capture.grab() for _ in range(READ_ON)):
            raise SourceError(f'source {spec!r}: {_why_unread(self._capture, spec)}')
        if is_unconverted(spec):
            raise SourceError(
                f'source {spec!r}: its pictures are interlaced, which OpenCV {cv2.__version__} '
                'cannot convert: make a file of whole ones, `ffmpeg -i OLD -vf yadif NEW.mp4`'
            )
        super().__init__(own_rate if own_rate > 0 else rate or DEFAULT_RATE)
        self._last, self._longest, self._shape = -1.0, 1.0, ()
        self.rewind()

    @staticmethod
    def accepts(spec: str) -> bool:
        """Accept anything: a spec of no other kind should be a file."""
        return True

    def read(self) -> Frame | None:
        """Return the next picture of the video."""
        if self._held is not None:
            held, self._held = self._held, None
            return held
        image, failed = self._next_image()
        if image is None:
            if not self._ended:
                self._tell_missing()
            return None
        frame = self._frame_at(self._time(), image)
        time = frame.stamp * 1e-9
        told = [f'{failed} pictures before {time:.3f} s cannot be read'] if failed else []
        self.lost += failed
        self._missing += failed
        told += self._tell_size(time)
        if not told:
            return frame
        self._held = frame
        raise SourceError(f'{self._path}: {", and ".join(told)}')

    def _check_size(self) -> None:
        """End at a picture of another size if OpenCV cannot read it.

        :raises SourceError: then.
        """
        if CUTS and self._sizes.changed and not self._ended:
            self._ended = True
            self.lost += max(self.total - self._given - self._missing, 1)
            raise SourceError(
                f'{self._path}: pictures change from {self._sizes}; to read the '
                'rest needs OpenCV 4.13'
            )

    def _tell_size(self, time: float) -> list[str]:
        """Count a picture that is not of the first size, and tell if the size has changed.

        :param time: time of the picture [s].
        """
        sizes = self._sizes
        self.lost += sizes.changed
        before, self._told = self._told, sizes.now
        if sizes.now == before or not any(before):
            return []
        if not sizes.changed:
            return [f'from {time:.3f} s on, pictures have their first size again']
        return [f'at {time:.3f} s, pictures change from {sizes}: scaled, and counted as lost']

    def _next_image(self) -> tuple[NDArray[np.uint8] | None, int]:
        """The next readable picture, None at the end, and the number of unreadable ones before."""
        tries = 1 + max(READ_ON, min(self.total, self._most) - self._given)
        for failed in range(tries if not self._ended else 0):
            self._sizes.step()
            self._check_size()
            read, image = self._capture.read()
            if read:
                self._given += 1
                return self._scaled(np.asarray(image, np.uint8)), failed
        return None, 0

    def _scaled(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The picture in the size of the first one; some versions of OpenCV do it themselves."""
        self._shape = self._shape or image.shape
        if image.shape == self._shape:
            return image
        height, width = self._shape[:2]
        return np.asarray(cv2.resize(image, (width, height)), np.uint8)

    def _time(self) -> float:
        """The time of the current picture in frames, from the container if plausible."""
        frames = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3 * self._rate
        if abs(frames - round(frames)) <= ROUNDING * self._rate:
            frames = round(frames)
        frames += self._first
        # At a variable rate, the last picture may last longer than the mean period, which may be
        # the mean of all but the last.
        end = self._first + max(self.total, self._given) + 2 * self._longest
        possible = self._last < frames < end
        frames = frames if possible else float(self._count)
        self._timed += possible
        self._following += possible and abs(frames - self._last - 1) < SAME_PERIOD
        self._longest = max(self._longest, frames - self._last)
        self._last = frames
        return self._last

    def _tell_missing(self) -> None:
        """Raise an error for pictures that the container claims but that were never read."""
        self._ended = True
        counted, indexed = expected_pictures(self._path), indexed_pictures(self._path)
        counted = counted or damaged_fragments(self._path, self._rate)
        end = last_picture(self._path)
        if counted is not None or indexed is not None:
            self.total, self._estimated = counted or indexed or 0, False
        elif end is not None and self.total:
            self.total = round(max(end * self._rate, self._last - self._first)) + 1
        missing = self.total - self._given - self._missing
        spare = 0 if counted is not None or self._missing else ESTIMATE
        if missing > spare and not self._is_varying():
            self.lost += missing
            raise SourceError(
                f'{self._path}: should have {self.total} pictures, {missing} more are missing'
            )
        if is_cut_off(self._path):
            self.lost += 1
            raise SourceError(
                f'{self._path}: is cut off within its last picture; it does not say how many more '
                'are missing'
            )

    def _is_varying(self) -> bool:
        """Whether pictures at a variable rate fill the duration that gave the estimated total.

        Losses in such a file are unknown, since the variable rate itself leaves out as many
        pictures.
        """
        end = self._last - self._first + self._longest >= self.total - ESTIMATE
        return self._estimated and end and self._following < CONSTANT_RATE * self._timed

    def rewind(self) -> None:
        """Reopen the file: seeking is inexact in some formats."""
        self._capture.release()
        self._capture = open_file(self._path)
        self._first = self._count
        self._given = self._missing = self._timed = self._following = 0
        self._held = None
        self._ended = False
        self._sizes = SizeWatch(self._path)  # the last one closes its file as it goes
        self._told = self._sizes.now

    def close(self) -> None:
        """Close the file."""
        self._capture.release()
        self._sizes.close()


def _why_unread(capture: cv2.VideoCapture, path: str) -> str:
    """Why a file gives no picture, and what to do about it."""
    if not capture.isOpened():
        if lacks_index(path):
            return (
                'its index, which is written last, is missing: the recording was cut off; untrunc, '
                'for one, makes another from a whole recording of the same camera'
            )
        return (
            'no video can be read from this file; expected mp4, mkv, avi, mov or another format of '
            'FFmpeg'
        )
    code = int(capture.get(cv2.CAP_PROP_FOURCC)) & 0xFFFFFFFF
    codec = code.to_bytes(4, 'little').decode('ascii', 'replace').strip('\0 ')
    return (
        f'none of its pictures can be decoded (codec {codec}): they are damaged, or OpenCV '
        f'{cv2.__version__} has no decoder for them; try `ffmpeg -i OLD -c:v libx264 NEW.mp4`'
    )
