"""The frames that the page shows, by number: of a recording any one, of a camera the last ones."""

from collections import OrderedDict

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.sources import open_source
from colortrack_ros.sources import Source
from colortrack_ros.sources import SourceError
from colortrack_ros.sources.base import DEFAULT_RATE

KEPT_BYTES = 512 * 1024**2
"""Pictures that are kept so that stepping back is quick: 580 of 640x480, 190 of 1280x720, an eighth
of the 4 GiB of a small computer."""


class Footage:
    """A recording whose frames have numbers from 0.

    Frames are read in order and kept as long as there is room; one that is kept no longer is read
    again from the beginning.

    :param label: what to call it.
    :param source: of the frames, not a live one; a frame that cannot be read is left out.
    :ivar total: frames that there are, as far as is known.
    :ivar rate: frames a second [Hz].
    """

    def __init__(self, label: str, source: Source) -> None:
        self.label, self.rate = label, NANOSECONDS / (source.period or NANOSECONDS / DEFAULT_RATE)
        self.total = source.total
        self._source = source
        self._kept: OrderedDict[int, Frame] = OrderedDict()
        self._bytes = 0
        self._next = 0
        self._whole = False

    def frame(self, number: int) -> Frame | None:
        """A frame; None behind the end.

        The stamp is that of the first reading, as if the recording had been played straight on.
        """
        if number in self._kept:
            self._kept.move_to_end(number)
            return self._kept[number]
        if number < self._next:
            self._source.rewind()
            self._next = 0
        while self._next <= number:
            frame = self._read()
            if frame is None:
                self.total, self._whole = self._next, True
                return None
            self._keep(self._next, frame)
            self._next += 1
        self.total = max(self.total, self._next)
        return self._kept[number]

    def last(self) -> int:
        """The number of the last frame there is, as far as is known."""
        return max(self.total - 1, 0)

    def close(self) -> None:
        """Let go of the files."""
        self._source.close()

    def _read(self) -> Frame | None:
        while True:
            try:
                frame = self._source.read()
            except SourceError:
                continue
            return frame

    def _keep(self, number: int, frame: Frame) -> None:
        period = NANOSECONDS / self.rate
        self._kept[number] = Frame(frame.image, frame.encoding, round(number * period))
        self._bytes += frame.image.nbytes
        while self._bytes > KEPT_BYTES and len(self._kept) > 1:
            _, old = self._kept.popitem(last=False)
            self._bytes -= old.image.nbytes


def open_footage(spec: str, rate: float = 0.0) -> Footage:
    """The frames of a video, pictures, or a scene.

    :param rate: frames a second, where the recording does not say [Hz].
    :raises SourceError: it cannot be opened, or is live.
    """
    source = open_source(spec, rate)
    if source.live:
        source.close()
        raise SourceError(f'source {spec!r}: is live; expected a video, pictures, or scene:NAME')
    return Footage(spec, source)
