"""Bags by the library rosbags, in plain Python, where ROS is not installed."""

from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
import contextlib
import copy
import heapq
from operator import itemgetter
from pathlib import Path
from typing import Any
from urllib.parse import quote

from rosbags.interfaces import Connection
from rosbags.interfaces import Qos
from rosbags.interfaces import QosDurability
from rosbags.interfaces import QosHistory
from rosbags.interfaces import QosLiveliness
from rosbags.interfaces import QosReliability
from rosbags.interfaces import QosTime
from rosbags.rosbag2 import CompressionMode
from rosbags.rosbag2 import Reader
from rosbags.rosbag2 import ReaderError
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_mcap import DECOMPRESSORS
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Writer
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

ZSTD_MAGIC = b'\x28\xb5\x2f\xfd'
"""How what is compressed with zstd begins; no serialized message does."""

_TYPES = get_typestore(Stores.ROS2_JAZZY)


def rewritten(cdr: bytes, kind: str) -> bytes:
    """Deserialize and reserialize a message, which sets its padding to zeros."""
    return bytes(_TYPES.serialize_cdr(_TYPES.deserialize_cdr(cdr, kind), kind))


class _Database(Sqlite3Reader):
    """A .db3, in place of rosbags' own reader of it.

    :raises OSError: its last messages are in another file, which rosbags does not read.
    """

    def __init__(self, path: Any) -> None:
        log = Path(f'{path}-wal')
        if log.exists() and log.stat().st_size:
            raise OSError(f'{log.name} is there: its recorder was killed, or is still recording')
        super().__init__(_in_uri(path))


class _NewDatabase(Sqlite3Writer):
    """A new .db3, in place of rosbags' own writer of it."""

    def __init__(self, path: Path, compression: CompressionMode) -> None:
        super().__init__(_in_uri(path), compression)
        self.path = path / f'{path.name}.db3'


def _in_uri(path: Any) -> Path:
    """The path as part of a URI: in one, run%20a is `run a`, and # and ? end a name."""
    return Path(quote(str(path)))


def _reader_of(path: Any) -> Reader:
    """The reader of a bag, or of one of its files, not open yet."""
    reader = Reader(path)
    if isinstance(reader.storage, DirectoryReader):
        plugins = reader.storage.STORAGE_PLUGINS
        reader.storage.STORAGE_PLUGINS = {**plugins, 'sqlite3': _Database}
    elif isinstance(reader.storage, Sqlite3Reader):
        reader.storage = _Database(path)
    return reader


class PortableFile:
    """A bag, or one of its files, as rosbags reads it.

    :ivar topics: with at least one message.
    :ivar duration: from the first message to the last [ns].
    """

    def __init__(self, path: Any) -> None:
        self._reader = _reader_of(path)
        _open(self._reader)
        with contextlib.ExitStack() as opened:
            opened.callback(self.close)
            for part in self._parts():
                if isinstance(part, McapReader) and not part.connections:
                    part.meta_scan()  # its index leaves out the topics, as it may
            opened.pop_all()  # it stays open from here on
        self.duration, connections = self._reader.duration, self._reader.connections
        sizes = {c.id: c.msgcount for c in connections}
        if found := getattr(self._reader.storage, 'statistics', None):
            sizes = found.channel_message_counts
            self.duration = max(found.end_time - found.start_time + 1, 0)
        self.topics = [
            Topic(c.topic, c.msgtype, sizes[c.id]) for c in connections if sizes.get(c.id)
        ]

    def _parts(self) -> list[Any]:
        """The readers of the files."""
        storage = self._reader.storage
        return list(storage.storages) if isinstance(storage, DirectoryReader) else [storage]

    def messages(self, topic: Topic) -> Iterator[tuple[int, bytes]]:
        """Log time [ns] and serialized content of each message of a topic, by log time.

        :raises Exception: parts of the bag cannot be read: the first reason, after all messages of
            the others.
        """
        failures: list[Exception] = []
        for part in self._parts():
            # Those of the files themselves: where their QoS is not that in metadata.yaml, as in
            # bags of other distributions or after `ros2 bag convert`, rosbags would give none.
            names = topic.name, topic.kind
            connections = [c for c in part.connections if (c.topic, c.msgtype) == names]
            try:
                for log_time, cdr in _messages(part, connections, failures) if connections else ():
                    # Of a bag compressed message by message, which only its metadata.yaml tells.
                    is_plain = cdr[: len(ZSTD_MAGIC)] != ZSTD_MAGIC
                    yield log_time, bytes(cdr if is_plain else DECOMPRESSORS['zstd'](cdr, 0))
            except Exception as error:
                failures.append(error)
        if failures:
            raise failures[0]

    def close(self) -> None:
        """Close the files."""
        self._reader.close()


def _open(reader: Reader) -> None:
    try:
        reader.open()
    except ReaderError as error:
        if 'Profile' in str(error):
            raise ReaderError('expected messages of ROS 2, with profile: ros2') from error
        raise


def _messages(
    part: Any, connections: Sequence[Connection], failures: list[Exception]
) -> Iterator[tuple[int, bytes]]:
    """Log time [ns] and content of each message of a file, by log time as far as it has an index.

    :param failures: takes the reasons why chunks cannot be read.
    """
    if isinstance(part, McapReader) and part.chunks:
        pieces = [_of_chunk(part, chunk, connections, failures) for chunk in part.chunks]
        for log_time, cdr in heapq.merge(*pieces, key=itemgetter(0)):
            if cdr is not None:
                yield log_time, cdr
        return
    read = part.messages_scan if isinstance(part, McapReader) else part.messages
    for _, log_time, cdr in read(connections):
        yield log_time, cdr


def _of_chunk(
    part: McapReader, chunk: Any, connections: Sequence[Connection], failures: list[Exception]
) -> Iterator[tuple[int, bytes | None]]:
    """The same of one chunk, after its first log time alone, which keeps it unread until then."""
    counts = chunk.channel_count
    if counts and not any(counts.get(connection.id) for connection in connections):
        return
    yield chunk.message_start_time, None
    alone = copy.copy(part)
    # The index need not tell which topics are in a chunk.
    alone.chunks = [chunk._replace(channel_count={c.id: 1 for c in connections})]
    try:
        for _, log_time, cdr in alone.messages(connections):
            yield log_time, cdr
    except Exception as error:
        failures.append(error)


class PortableBag:
    """A bag that is being written, with message definitions, type hashes and QoS as in Jazzy."""

    def __init__(
        self, path: Path, topics: Mapping[str, str], storage: str, mark: tuple[str, str]
    ) -> None:
        plugin = _PLUGINS[storage]
        self._writer = Writer(path, version=Writer.VERSION_LATEST, storage_plugin=plugin)
        plugins = self._writer.STORAGE_PLUGINS
        self._writer.STORAGE_PLUGINS = {**plugins, StoragePlugin.SQLITE3: _NewDatabase}
        self._writer.set_custom_data(*mark)
        self._writer.open()
        with self._closed_if_it_fails():
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
        with self._closed_if_it_fails():
            self._writer.close()

    @contextlib.contextmanager
    def _closed_if_it_fails(self) -> Iterator[None]:
        """Close the file although it cannot be finished, as on a full disk."""
        try:
            yield
        except Exception:
            with contextlib.suppress(Exception):  # what cannot be written is told already
                self._writer.abort()
            raise
