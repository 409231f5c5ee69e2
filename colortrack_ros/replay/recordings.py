"""The input of ``replay``: the pictures or detections of a bag, or a source of frames."""

from abc import ABC
from abc import abstractmethod
from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
import dataclasses
from pathlib import Path
from typing import NamedTuple

from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image

from colortrack_ros.bags import BagError
from colortrack_ros.bags import BagReader
from colortrack_ros.bags import Topic
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.messages import BOXES
from colortrack_ros.messages import image_size_of_serialized_camera_info
from colortrack_ros.messages import MessageError
from colortrack_ros.node_kit.detections_intake import CLOUD
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.nodes.tracker import TrackerSetup
from colortrack_ros.replay.setup import Setup
from colortrack_ros.replay.viewpoints import CAMERA_INFO
from colortrack_ros.replay.viewpoints import RecordedViewpoints
from colortrack_ros.sources import Grabber
from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError

IMAGE = 'sensor_msgs/msg/Image'
COMPRESSED = 'sensor_msgs/msg/CompressedImage'
MESSAGES = {IMAGE: Image, COMPRESSED: CompressedImage}
LISTED = 8
"""Topics named in a bag that has none of these: as many as fit into two lines. Chosen."""


class Item(NamedTuple):
    """A picture, or the detections of one.

    :param log_time: when it was recorded [ns].
    :param content: the frame or detections.
    :param cdr: the recorded message, empty if there was none that nodes publish.
    """

    log_time: int
    content: Frame | Detections
    cdr: bytes = b''

    @property
    def stamp(self) -> int:
        """Stamp of the header [ns]."""
        return self.content.stamp


class Recording(ABC):
    """Frames or detections in the order in which they were recorded.

    :ivar label: its name in messages to the user.
    :ivar total: number of messages, 0 if unknown.
    :ivar rate: frames per second [Hz].
    :ivar has_pictures: whether the items are frames.
    :ivar refused: number of invalid messages or pictures so far.
    :ivar reason: of the last refusal.
    :ivar late: number of messages dropped because they came too late.
    :ivar viewpoints: poses of the camera, if the tracker needs them.
    :ivar warn: takes what is told of an item.
    """

    viewpoints: RecordedViewpoints | None = None
    label: str
    total: int
    rate: float
    has_pictures: bool

    def __init__(self) -> None:
        self.refused = self.late = 0
        self.reason = ''
        self.warn: Callable[[str], object] = lambda _: None

    def refuse(self, reason: str) -> None:
        """Count invalid input."""
        self.refused += 1
        self.reason = reason

    def drop(self, _: str) -> None:
        """Count a message that came too late."""
        self.late += 1

    @property
    def lost(self) -> int:
        """Number of pictures that could not be read so far."""
        return 0

    @abstractmethod
    def items(self) -> Iterator[Item]:
        """All items, once.

        :raises BagError: the bag is broken from there on.
        """

    def interrupt(self) -> None:  # noqa: B027
        """Interrupt a wait for the next item, from another thread."""

    @abstractmethod
    def close(self) -> None:
        """Let go of the files."""


class SourceRecording(Recording):
    """A video, pictures or a scene, with stamps from zero.

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
            of_ros_1 = '; convert a .bag of ROS 1 with rosbags-convert' * spec.endswith('.bag')
            raise StartError(f'{error}; or a bag: a folder, .mcap or .db3{of_ros_1}') from error
        if source.live:
            source.close()
            raise StartError(f'{spec}: is live; expected a recording, such as a bag or a video')
        self.label = spec
        self.rate = NANOSECONDS / source.period
        self._frame_id = str(camera['frame_id'])
        self._grabber = Grabber(source)

    def items(self) -> Iterator[Item]:
        """Every frame once."""
        while True:
            try:
                frame = self._grabber.read()
            except SourceError as error:
                self.refuse(str(error))
                continue
            if frame is None:
                return
            frame = dataclasses.replace(frame, frame_id=self._frame_id)
            yield Item(frame.stamp, frame)

    @property
    def lost(self) -> int:
        """Number of pictures that the video or the folder should have."""
        return self._grabber.lost

    def interrupt(self) -> None:
        """Stop waiting for a drive that does not answer."""
        self._grabber.close()

    def close(self) -> None:
        """Stop the thread that reads ahead."""
        self._grabber.close()


class BagRecording(Recording):
    """One topic of a bag.

    :param path: of the bag.
    :param topic: the one to process, or empty for the one that the parameters name.
    :raises BagError: it cannot be opened.
    :raises StartError: it has no suitable topic.
    """

    def __init__(self, path: Path, topic: str, setup: Setup) -> None:
        super().__init__()
        self._reader = BagReader(path)
        names = setup.topics['image'], setup.topics['detections']
        self._intake = setup.intake
        try:
            self._topic = choose(self._reader.topics, topic, *names, _kinds_of(setup, topic))
        except StartError as error:
            self._reader.close()
            raise StartError(f'{path}: {error}') from error
        self.label = f'{path}, {self._topic.name}'
        self.total = self._topic.size
        self.rate = (self.total - 1) * NANOSECONDS / max(self._reader.duration, 1)
        self.has_pictures = self._topic.kind in MESSAGES
        self._broken: BagError | None = None
        if setup.detections:
            self._detections = setup.detections.reader_of(
                self._topic.kind, lambda line: self.warn(line)
            )
        self._image_size = (0, 0) if self.has_pictures else self._size_of(setup)
        if name := setup.topics['odometry']:
            assert isinstance(setup.tracker, TrackerSetup)
            info, pose = setup.topics['camera_info'], setup.tracker.pose
            try:
                self.viewpoints = RecordedViewpoints(path, pose, info, name)
            except StartError:
                self._reader.close()
                raise

    def _size_of(self, setup: Setup) -> tuple[int, int]:
        """Picture size, from the first CameraInfo recorded with the detections."""
        name = setup.topics['camera_info']
        topic = next((t for t in self._reader.topics if t[:2] == (name, CAMERA_INFO)), None)
        if topic is None:
            return 0, 0
        try:
            _, cdr = next(self._reader.messages(topic))
            return image_size_of_serialized_camera_info(cdr)
        except BagError as error:
            self._broken = error  # raised after the detections, which may be whole
            return 0, 0
        except MessageError as error:
            self.refuse(str(error))
            return 0, 0

    def items(self) -> Iterator[Item]:
        """Every frame once."""
        for log_time, cdr in self._reader.messages(self._topic):
            try:
                content = self._content(cdr)
            except MessageError as error:
                self.refuse(str(error))
                continue
            if isinstance(content, Detections):
                content = dataclasses.replace(content, image_size=self._image_size)
            yield Item(log_time, content, b'' if self._topic.kind == BOXES else cdr)
        if self._broken:
            raise self._broken

    def _content(self, cdr: bytes) -> Frame | Detections:
        if not self.has_pictures:
            return self._detections(cdr)
        return self._intake.frame_of(cdr, MESSAGES[self._topic.kind])

    def close(self) -> None:
        """Let go of the files."""
        self._reader.close()
        if self.viewpoints:
            self.viewpoints.close()


def _kinds_of(setup: Setup, topic: str) -> tuple[str, ...]:
    """The types that the topic may have: if it is not named, and boxes are expected, only that."""
    if setup.detections is None:
        return tuple(MESSAGES)
    if setup.detections.detections_type == BOXES and not topic:
        return (BOXES,)
    return *MESSAGES, CLOUD, BOXES


def choose(
    topics: Sequence[Topic],
    wanted: str,
    image: str,
    detections: str,
    kinds: Sequence[str] = (*MESSAGES, CLOUD, BOXES),
) -> Topic:
    """The topic to process.

    It is the requested one, if any; otherwise that of the images, raw or compressed, or the only
    one that has images, where those compressed beside the raw ones do not count; in a bag without
    images that of the detections, or the only one of such a type.

    :param kinds: types that it may have.
    :raises StartError: none is suitable, or several are; the reason lists them.
    """
    usable = [t for t in topics if t.kind in kinds]
    images = [t for t in usable if t.kind in MESSAGES]
    names = [wanted, f'/{wanted}'] if wanted else [image, f'{image}/compressed']
    if not wanted and not images and detections:
        names = [detections]
    for name in names:
        for topic in usable:
            if topic.name == name:
                return topic
    raw = {t.name for t in images if t.kind == IMAGE}
    images = [t for t in images if t.name in raw or t.name.removesuffix('/compressed') not in raw]
    candidates = images or usable
    if not wanted and len(candidates) == 1:
        return candidates[0]
    if not usable:
        there = ', '.join(f'{t.name} ({t.kind})' for t in topics[:LISTED]) or 'none'
        raise StartError(
            f'no topic {names[0]} there, nor another of {" or ".join(kinds)}; there is {there}'
        )
    listed = ', '.join(f'{t.name} ({t.kind}, {t.size})' for t in usable)
    raise StartError(f'no topic {names[0]} there; topics that --topic may choose: {listed}')
