"""What ``replay`` works on: the pictures or the detections of a bag, or a source of frames."""

from abc import ABC
from abc import abstractmethod
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
import dataclasses
from pathlib import Path
from typing import NamedTuple

from colortrack_ros.bags import BagError
from colortrack_ros.bags import BagReader
from colortrack_ros.bags import StampOrder
from colortrack_ros.bags import Topic
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.messages import detections_of_serialized_cloud
from colortrack_ros.messages import frame_of_serialized_compressed_image
from colortrack_ros.messages import frame_of_serialized_image
from colortrack_ros.messages import MessageError
from colortrack_ros.messages import stamp_of_serialized
from colortrack_ros.nodes.runtime import StartError
from colortrack_ros.sources import Grabber
from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError

IMAGE = 'sensor_msgs/msg/Image'
COMPRESSED = 'sensor_msgs/msg/CompressedImage'
CLOUD = 'sensor_msgs/msg/PointCloud2'

WINDOW = NANOSECONDS // 2
"""So much later than its place [ns] a message may stand in a bag."""


class Item(NamedTuple):
    """What the tracker advances on.

    :param number: of the frame in the recording, from 1; one that is refused has a number as well.
    :param log_time: of the messages that come from it [ns], never less than that of the one before.
    :param content: a picture, or the detections of one.
    :param cdr: the message that was recorded, empty where there was none.
    """

    number: int
    log_time: int
    content: Frame | Detections
    cdr: bytes = b''


class Recording(ABC):
    """Frames or detections in the order of their stamps.

    :ivar label: what it is, in words.
    :ivar total: number of messages, 0 where nobody knows.
    :ivar rate: frames a second [Hz].
    :ivar has_pictures: whether the items are frames.
    :ivar refused: number of messages or pictures that cannot be right, so far.
    :ivar reason: of the last refusal.
    :ivar late: number of messages dropped since they came too late for their place.
    :ivar duplicates: number of messages dropped since their stamp was there already.
    """

    label: str
    total: int
    rate: float
    has_pictures: bool

    def __init__(self) -> None:
        self.refused = self.late = self.duplicates = 0
        self.reason = ''

    def refuse(self, reason: str) -> None:
        """Count input that cannot be right."""
        self.refused += 1
        self.reason = reason

    @abstractmethod
    def items(self) -> Iterator[Item]:
        """Every frame once.

        :raises BagError: the bag is broken there; what could be read has been given out.
        """

    @abstractmethod
    def close(self) -> None:
        """Let go of the files."""


class SourceRecording(Recording):
    """A video, pictures or a scene, stamped from zero on.

    :param spec: as the camera takes it.
    :param camera: the values of the camera's parameters.
    :raises StartError: it cannot be opened, or it is live.
    """

    total = 0
    has_pictures = True

    def __init__(self, spec: str, camera: Mapping[str, object]) -> None:
        super().__init__()
        try:
            source = open_source(spec, max(float(str(camera['rate'])), 0.0))
        except SourceError as error:
            raise StartError(f'{error}; or a bag: a folder, .mcap or .db3') from error
        if source.live:
            source.close()
            raise StartError(f'{spec}: is live; expected a recording, such as a bag or a video')
        self.label = spec
        self.rate = NANOSECONDS / source.period
        self._frame_id = str(camera['frame_id'])
        self._grabber = Grabber(source)

    def items(self) -> Iterator[Item]:
        """Every frame once."""
        number = 0
        while True:
            number += 1
            try:
                frame = self._grabber.read()
            except SourceError as error:
                self.refuse(str(error))
                continue
            if frame is None:
                return
            frame = dataclasses.replace(frame, frame_id=self._frame_id)
            yield Item(number, frame.stamp, frame)

    def close(self) -> None:
        """End the thread that reads ahead."""
        self._grabber.close()


class BagRecording(Recording):
    """One topic of a bag.

    :param path: of the bag.
    :param topic: the one to work on, or empty for the one that the parameters mean.
    :param topics: full names of the nodes' topics, ``image`` and ``detections``.
    :param max_late: what comes later than the window by more than this [ns] is not late: time has
        gone back.
    :raises BagError: it cannot be opened.
    :raises StartError: no topic in it is the one.
    """

    def __init__(self, path: Path, topic: str, topics: Mapping[str, str], max_late: int) -> None:
        super().__init__()
        self._reader = BagReader(path)
        try:
            self._topic = choose(self._reader.topics, topic, topics['image'], topics['detections'])
        except StartError as error:
            self._reader.close()
            raise StartError(f'{path}: {error}') from error
        self._order: StampOrder[tuple[int, bytes]] = StampOrder(WINDOW, WINDOW + max_late)
        self.label = f'{path}, {self._topic.name}'
        self.total = self._topic.size
        self.rate = (self.total - 1) * NANOSECONDS / max(self._reader.duration, 1)
        self.has_pictures = self._topic.kind != CLOUD

    def items(self) -> Iterator[Item]:
        """Every frame once."""
        log_time = 0
        for number, (recorded, cdr) in enumerate(self._ordered(), 1):
            log_time = max(log_time, recorded)
            try:
                content = _content(cdr, self._topic.kind)
            except MessageError as error:
                self.refuse(str(error))
                continue
            yield Item(number, log_time, content, cdr)

    def _ordered(self) -> Iterator[tuple[int, bytes]]:
        broken = None
        try:
            for log_time, cdr in self._reader.messages(self._topic):
                try:
                    yield from self._order.put(stamp_of_serialized(cdr), (log_time, cdr))
                except MessageError as error:
                    self.refuse(str(error))
                self.late, self.duplicates = self._order.late, self._order.duplicates
        except BagError as error:
            broken = error
        yield from self._order.rest()
        self.duplicates = self._order.duplicates
        if broken:
            raise broken

    def close(self) -> None:
        """Let go of the files."""
        self._reader.close()


def choose(topics: Sequence[Topic], wanted: str, image: str, detections: str) -> Topic:
    """The topic to work on.

    It is the wanted one if any; else the one of the images, raw or compressed, or the only one that
    has images; in a bag without images the one of the detections, or the only point cloud.

    :raises StartError: there is none, or several may be meant: they are listed.
    """
    usable = [t for t in topics if t.kind in (IMAGE, COMPRESSED, CLOUD)]
    images = [t for t in usable if t.kind != CLOUD]
    names = [wanted, f'/{wanted}'] if wanted else [image, f'{image}/compressed']
    if not wanted and not images:
        names = [detections]
    for name in names:
        for topic in usable:
            if topic.name == name:
                return topic
    candidates = images or usable
    if not wanted and len(candidates) == 1:
        return candidates[0]
    listed = ', '.join(f'{t.name} ({t.kind}, {t.size})' for t in usable) or 'none'
    raise StartError(f'no topic {names[0]} there; topics that --topic may choose: {listed}')


def _content(cdr: bytes, kind: str) -> Frame | Detections:
    if kind == IMAGE:
        return frame_of_serialized_image(cdr)
    if kind == COMPRESSED:
        return frame_of_serialized_compressed_image(cdr)
    return detections_of_serialized_cloud(cdr)
