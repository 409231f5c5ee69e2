"""The interface of an open recording, whichever library reads it."""

from collections.abc import Iterator
from typing import NamedTuple
from typing import Protocol

BAG_SUFFIXES = ('.mcap', '.db3')
"""Suffixes of the files of a rosbag2, by storage plugin: mcap, sqlite3."""

ZSTD_SUFFIX = '.zstd'
"""Suffix that follows these where whole files are compressed."""

STORAGES = ('mcap', 'sqlite3')
"""The storage plugins; the first is the default of `ros2 bag record`."""


MAX_METADATA = 1 << 26
"""Maximum size of metadata.yaml [bytes]: that of a bag of 100,000 files."""


class Topic(NamedTuple):
    """One topic of a bag.

    :param name: of the topic, with its namespace.
    :param kind: type of its messages, such as ``sensor_msgs/msg/Image``.
    :param size: number of its messages.
    """

    name: str
    kind: str
    size: int


class BagFile(Protocol):
    """A recording, or a part of one, that is open."""

    topics: list[Topic]
    duration: int

    def messages(self, topic: Topic) -> Iterator[tuple[int, bytes]]:
        """Log time [ns] and serialized content of each message of a topic."""

    def close(self) -> None:
        """Close the file."""
