"""Bags for the tests of replay: written from scenes, read as messages."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from nav_msgs.msg import Odometry
import numpy as np
from rclpy.serialization import deserialize_message
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray
import yaml

from colortrack_ros.bags import BagReader
from colortrack_ros.bags import BagWriter
from colortrack_ros.data import TRACK
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import stamp_of
from colortrack_ros.sources import open_source

SCENE = 'scene:five?width=320&height=240&rate=6&duration=12'
START = 1_700_000_000_123_456_789
TOPICS = {'/detections': PointCloud2, '/tracks': PointCloud2, '/tracks/markers': MarkerArray}
"""What replay writes."""

KINDS = {
    'nav_msgs/msg/Odometry': Odometry,
    'sensor_msgs/msg/CameraInfo': CameraInfo,
    'sensor_msgs/msg/Image': Image,
    'sensor_msgs/msg/CompressedImage': CompressedImage,
    'sensor_msgs/msg/PointCloud2': PointCloud2,
    'visualization_msgs/msg/MarkerArray': MarkerArray,
}
NAMES = {kind: name for name, kind in KINDS.items()}


@dataclass(frozen=True)
class Message:
    """One of a bag, whose content is read only where a test asks for it."""

    topic: str
    kind: str
    log_time: int
    cdr: bytes

    @cached_property
    def content(self) -> object:
        return deserialize_message(self.cdr, KINDS[self.kind])


def read_bag(path: Path | str, *names: str) -> list[Message]:
    """All messages, topic by topic, or those of some topics."""
    reader = BagReader(Path(path))
    found = [
        Message(topic.name, topic.kind, log_time, cdr)
        for topic in reader.topics
        if not names or topic.name in names
        for log_time, cdr in reader.messages(topic)
    ]
    reader.close()
    return found


def of_topic(path: Path | str, topic: str) -> list[Message]:
    return read_bag(path, topic)


def write_bag(path: Path, messages: dict[str, list], storage: str = 'mcap', delay: int = 0) -> Path:
    """A bag of these messages, by topic, logged so long [ns] after their stamp, in their order."""
    bag = BagWriter(path, {t: NAMES[type(ms[0])] for t, ms in messages.items()}, storage)
    for topic, some in messages.items():
        log_time = -1
        for message in some:
            log_time = max(log_time + 1, stamp_of(message.header) + delay)
            bag.write(topic, log_time, serialize_message(message))
    bag.close()
    return path


def short_bag(path: Path, messages: dict[str, list]) -> Path:
    """A bag that lacks the last five messages of each topic."""
    metadata = write_bag(path, messages) / 'metadata.yaml'
    told = yaml.safe_load(metadata.read_text())
    for entry in told['rosbag2_bagfile_information']['topics_with_message_count']:
        entry['message_count'] += 5
    metadata.write_text(yaml.safe_dump(told))
    return path


def frames(spec: str, start: int = 0) -> list:
    """The frames of a source, as Image messages of a camera that starts at a time [ns]."""
    source = open_source(spec)
    found = []
    while (frame := source.read()) is not None:
        message = image_of_frame(frame)
        message.header.frame_id = 'cam'
        seconds, nanoseconds = divmod(start + frame.stamp, 10**9)
        message.header.stamp.sec, message.header.stamp.nanosec = seconds, nanoseconds
        found.append(message)
    return found


def contents(path: Path | str) -> list[tuple[str, int, bytes]]:
    """Topic, time, and bytes of each message."""
    return [(m.topic, m.log_time, m.cdr) for m in read_bag(path)]


def tracks_of(path: Path | str) -> list[np.ndarray]:
    """The rows of each message of tracks."""
    return [np.frombuffer(m.content.data, TRACK) for m in of_topic(path, '/tracks')]


def topics_of(path: Path | str) -> set[str]:
    reader = BagReader(Path(path))
    names = {topic.name for topic in reader.topics}
    reader.close()
    return names
