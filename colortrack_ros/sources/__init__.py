"""sources: frames from a device, video file, stream, folder of pictures, or rendered scene."""

from pathlib import Path
import time

from colortrack_ros.files import in_time
from colortrack_ros.files import require_utf8
from colortrack_ros.sources.base import Source
from colortrack_ros.sources.base import SourceError
from colortrack_ros.sources.capture import Now
from colortrack_ros.sources.device import DeviceSource
from colortrack_ros.sources.grabber import Grabber
from colortrack_ros.sources.pictures import PicturesSource
from colortrack_ros.sources.scene import SceneSource
from colortrack_ros.sources.stream import StreamSource
from colortrack_ros.sources.stream import without_secrets
from colortrack_ros.sources.video import VideoSource

__all__ = ['SOURCES', 'Grabber', 'Source', 'SourceError', 'open_source']

SOURCES = (SceneSource, StreamSource, DeviceSource, PicturesSource, VideoSource)
"""All kinds of sources; the first that accepts a spec opens it. VideoSource accepts any."""

FILES = (PicturesSource, VideoSource)
"""Kinds that have no timeout of their own for opening."""

TIME_TO_OPEN = 10.0
"""Timeout for opening a file [s]: on a dead network drive it would block forever."""


def open_source(spec: str | Path | int, rate: float = 0.0, clock: Now = time.time_ns) -> Source:
    """Open a device, a video file, a stream, a folder or pattern of pictures, or a scene.

    :param spec: `0`, `/dev/video0`, `ball.mp4`, `rtsp://host/path`, `http://host/stream.mjpg`,
        `shots`, `shots/*.png`, `scene:five`, `scene:five?width=640&height=480&noise=0`; a Path or
        the number of a device is the same as its text.
    :param rate: frames per second, for sources without a rate of their own (pictures) and for those
        that can be asked for one (devices); 0: the default [Hz].
    :param clock: returns the time [ns]; called at each grab of a live source.
    :raises SourceError: if it cannot be opened: one line that names what was given and what would
        work.
    """
    if not isinstance(spec, (str, Path, int)):
        raise SourceError(f'source {spec!r}: expected a text, a Path or the number of a device')
    return _opened(str(spec), rate, clock)


def _opened(spec: str, rate: float, clock: Now) -> Source:
    try:
        kind = in_time(lambda: next(kind for kind in SOURCES if kind.accepts(spec)), TIME_TO_OPEN)
        if kind is not PicturesSource:
            require_utf8(spec)
        if kind not in FILES:
            return kind(spec, rate, clock)
        return in_time(lambda: kind(spec, rate, clock), TIME_TO_OPEN)
    except UnicodeError as error:
        raise SourceError(f'source {without_secrets(spec)!r}: {error}') from error
    except TimeoutError as error:
        raise SourceError(
            f'source {spec!r}: could not be opened {error}; is it on a drive that does not answer?'
        ) from None
