"""What an open recording is, whichever library reads it."""

from collections.abc import Iterator
from typing import NamedTuple
from typing import Protocol

BAG_SUFFIXES = ('.mcap', '.db3')
"""What the files of a rosbag2 end in, by storage plugin: mcap, sqlite3."""

STORAGES = ('mcap', 'sqlite3')
"""What a bag may be stored in; the first is what `ros2 bag record` takes."""


MAX_METADATA = 1 << 26
"""Size of the largest metadata.yaml [bytes]: that of a bag of 100,000 files."""


class Topic(NamedTuple):
    """What a bag holds of one topic.

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
        """Let go of the file."""
