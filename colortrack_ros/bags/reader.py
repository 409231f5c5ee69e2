"""Reading a rosbag2."""

from collections.abc import Iterator
import contextlib
from pathlib import Path
from typing import NamedTuple

from rosbags.rosbag2 import Reader

from colortrack_ros.bags.errors import BagError

BAG_SUFFIXES = ('.mcap', '.db3')
"""What the files of a rosbag2 end in, by storage plugin: mcap, sqlite3."""


class Topic(NamedTuple):
    """What a bag holds of one topic.

    :param name: of the topic, with its namespace.
    :param kind: type of its messages, such as ``sensor_msgs/msg/Image``.
    :param size: number of its messages.
    """

    name: str
    kind: str
    size: int


def is_bag(path: Path) -> bool:
    """Whether the path means a bag: one of its files, or a folder of them."""
    if path.is_dir():
        return any(p.name == 'metadata.yaml' or p.suffix in BAG_SUFFIXES for p in path.iterdir())
    return path.suffix in BAG_SUFFIXES


class BagReader:
    """A rosbag2: a folder with its metadata.yaml, or a single .mcap or .db3 file.

    :ivar topics: with at least one message, by name.
    :ivar duration: from the first message to the last [ns].
    :raises BagError: it cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        if path.is_dir() and not (path / 'metadata.yaml').is_file():
            raise BagError(
                f'{path}: a bag without its metadata.yaml; give one of its files, or run '
                '`ros2 bag reindex` on it'
            )
        with self._explained():
            self._reader = Reader(path)
            self._reader.open()
            self.duration = self._reader.duration
            self.topics = [
                Topic(c.topic, c.msgtype, c.msgcount)
                for c in sorted(self._reader.connections, key=lambda c: c.topic)
                if c.msgcount
            ]

    def messages(self, topic: Topic) -> Iterator[tuple[int, bytes]]:
        """Log time [ns] and serialized content of each message of a topic, in order of log times.

        :raises BagError: the file is broken there.
        """
        connections = [
            c for c in self._reader.connections if (c.topic, c.msgtype) == (topic.name, topic.kind)
        ]
        with self._explained():
            for _, log_time, cdr in self._reader.messages(connections):
                yield log_time, bytes(cdr)

    def close(self) -> None:
        """Let go of the files."""
        self._reader.close()

    @contextlib.contextmanager
    def _explained(self) -> Iterator[None]:
        """Errors of the library as BagError: a broken file raises nearly anything in there."""
        try:
            yield
        except Exception as error:
            raise BagError(f'{self._path}: this bag cannot be read: {_one_line(error)}') from error


def _one_line(error: Exception) -> str:
    return ' '.join(str(error).split()) or type(error).__name__
