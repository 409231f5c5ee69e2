"""Bags by the library rosbags, in plain Python, where ROS is not installed."""

from collections.abc import Iterator
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rosbags.interfaces import Qos
from rosbags.interfaces import QosDurability
from rosbags.interfaces import QosHistory
from rosbags.interfaces import QosLiveliness
from rosbags.interfaces import QosReliability
from rosbags.interfaces import QosTime
from rosbags.rosbag2 import Reader
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.typesys import get_typestore
from rosbags.typesys import Stores

from colortrack_ros.bags.bag_file import Topic

_PLUGINS = {'mcap': StoragePlugin.MCAP, 'sqlite3': StoragePlugin.SQLITE3}

_INFINITE = QosTime(9223372036, 854775807)
"""RMW_DURATION_INFINITE: 2^63 - 1 ns."""

_QOS = Qos(
    history=QosHistory.KEEP_LAST,
    depth=10,
    reliability=QosReliability.RELIABLE,
    durability=QosDurability.VOLATILE,
    deadline=_INFINITE,
    lifespan=_INFINITE,
    liveliness=QosLiveliness.AUTOMATIC,
    liveliness_lease_duration=_INFINITE,
    avoid_ros_namespace_conventions=False,
)
"""The QoS that `ros2 bag play` will publish with: a reliable publisher matches every subscriber."""

_TYPES = get_typestore(Stores.ROS2_JAZZY)


def rewritten(cdr: bytes, kind: str) -> bytes:
    """Deserialize and reserialize a message, which sets its padding to zeros."""
    return bytes(_TYPES.serialize_cdr(_TYPES.deserialize_cdr(cdr, kind), kind))


class PortableFile:
    """A bag, or one of its files, as rosbags reads it.

    :ivar topics: with at least one message.
    :ivar duration: from the first message to the last [ns].
    """

    def __init__(self, path: Any) -> None:
        self._reader = Reader(path)
        self._reader.open()
        self.duration = self._reader.duration
        self.topics = [
            Topic(c.topic, c.msgtype, c.msgcount) for c in self._reader.connections if c.msgcount
        ]

    def messages(self, topic: Topic) -> Iterator[tuple[int, bytes]]:
        """Log time [ns] and serialized content of each message of a topic, by log time."""
        # Those of the files themselves: where their QoS is not that in metadata.yaml, as in bags
        # of other distributions or after `ros2 bag convert`, rosbags would give none.
        storage = self._reader.storage
        parts = storage.storages if isinstance(storage, DirectoryReader) else [storage]
        connections = [
            c
            for part in parts
            for c in part.connections
            if (c.topic, c.msgtype) == (topic.name, topic.kind)
        ]
        for _, log_time, cdr in self._reader.messages(connections) if connections else ():
            yield log_time, bytes(cdr)

    def close(self) -> None:
        """Close the files."""
        self._reader.close()


class PortableBag:
    """A bag that is being written, with message definitions, type hashes and QoS as in Jazzy."""

    def __init__(
        self, path: Path, topics: Mapping[str, str], storage: str, mark: tuple[str, str]
    ) -> None:
        plugin = _PLUGINS[storage]
        self._writer = Writer(path, version=Writer.VERSION_LATEST, storage_plugin=plugin)
        self._writer.set_custom_data(*mark)
        self._writer.open()
        self._connections = {
            topic: self._writer.add_connection(
                topic, kind, typestore=_TYPES, offered_qos_profiles=[_QOS]
            )
            for topic, kind in topics.items()
        }

    def write(self, topic: str, log_time: int, cdr: bytes) -> None:
        """Add a message."""
        self._writer.write(self._connections[topic], log_time, cdr)

    def close(self) -> None:
        """Write the index and the metadata."""
        self._writer.close()
