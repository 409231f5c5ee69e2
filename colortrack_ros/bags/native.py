"""Bags by ROS's own library, rosbag2_py, where ROS is installed."""

from collections.abc import Iterator
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import rosbag2_py

from colortrack_ros.bags.bag_file import Topic

CDR = rosbag2_py.ConverterOptions('cdr', 'cdr')
"""Messages as they are on the wire, without conversion."""


class NativeFile:
    """A bag, or one of its files.

    :ivar topics: with at least one message.
    :ivar duration: from the first message to the last [ns].
    """

    def __init__(self, path: Path) -> None:
        self._options = rosbag2_py.StorageOptions(uri=str(path))
        metadata = rosbag2_py.Info().read_metadata(str(path), '')
        compressed = bool(metadata.compression_format)
        self._kind = (
            rosbag2_py.SequentialCompressionReader if compressed else rosbag2_py.SequentialReader
        )
        self._open()  # raises now if it cannot be opened
        self.duration = int(metadata.duration.nanoseconds)
        self.topics = [
            Topic(t.topic_metadata.name, t.topic_metadata.type, t.message_count)
            for t in metadata.topics_with_message_count
            if t.message_count
        ]

    def _open(self) -> Any:
        reader = self._kind()
        reader.open(self._options, CDR)
        return reader

    def messages(self, topic: Topic) -> Iterator[tuple[int, bytes]]:
        """Log time [ns] and serialized content of each message of a topic, by log time."""
        reader = self._open()
        reader.set_filter(rosbag2_py.StorageFilter(topics=[topic.name]))
        while reader.has_next():
            _, cdr, log_time = reader.read_next()
            yield log_time, cdr

    def close(self) -> None:
        """Nothing stays open between two loops over messages."""


class NativeBag:
    """A bag that is being written; see :class:`~colortrack_ros.bags.BagWriter`."""

    def __init__(
        self, path: Path, topics: Mapping[str, str], storage: str, mark: tuple[str, str]
    ) -> None:
        self._writer = rosbag2_py.SequentialWriter()
        options = {'uri': str(path), 'storage_id': storage, 'custom_data': dict([mark])}
        self._writer.open(rosbag2_py.StorageOptions(**options), CDR)
        for number, (name, kind) in enumerate(topics.items()):
            self._writer.create_topic(
                rosbag2_py.TopicMetadata(
                    id=number, name=name, type=kind, serialization_format='cdr'
                )
            )

    def write(self, topic: str, log_time: int, cdr: bytes) -> None:
        """Add a message."""
        self._writer.write(topic, cdr, log_time)

    def close(self) -> None:
        """Write the index and the metadata."""
        self._writer.close()
