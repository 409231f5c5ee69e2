"""Writing a rosbag2."""

from collections.abc import Iterator
from collections.abc import Mapping
import contextlib
from pathlib import Path

from rosbags.interfaces import Qos
from rosbags.interfaces import QosDurability
from rosbags.interfaces import QosHistory
from rosbags.interfaces import QosLiveliness
from rosbags.interfaces import QosReliability
from rosbags.interfaces import QosTime
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer
from rosbags.typesys import get_typestore
from rosbags.typesys import Stores
import yaml

from colortrack_ros.bags.errors import BagError
from colortrack_ros.bags.errors import BagWriteError
from colortrack_ros.bags.reader import BAG_SUFFIXES

STORAGES = {'mcap': StoragePlugin.MCAP, 'sqlite3': StoragePlugin.SQLITE3}
"""What a bag may be stored in; the first is what `ros2 bag record` takes."""

MARK = 'written_by', 'colortrack_ros'
"""Key and value in the metadata of what this package has written, and may therefore replace."""

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
"""What `ros2 bag play` publishes with: every subscriber hears a reliable publisher."""

_TYPES = get_typestore(Stores.ROS2_JAZZY)


def canonical(cdr: bytes, kind: str) -> bytes:
    """The same message with zeros between its fields, where Fast CDR leaves what was in memory.

    :param cdr: a serialized message.
    :param kind: its type.
    """
    return bytes(_TYPES.serialize_cdr(_TYPES.deserialize_cdr(cdr, kind), kind))


class BagWriter:
    """A rosbag2 as Jazzy writes it, with message definitions, type hashes and QoS.

    The same messages give the same bytes. What is written can be read after :meth:`close` alone.

    :param path: a folder that is not there yet.
    :param topics: type of the messages of each topic, by the topic's name.
    :param storage: a key of STORAGES.
    :raises BagError: the folder is there already or cannot be made.
    """

    def __init__(self, path: Path, topics: Mapping[str, str], storage: str = 'mcap') -> None:
        if path.exists():
            raise BagError(f'{path}: is there already; it is not overwritten')
        self._writer = Writer(path, version=Writer.VERSION_LATEST, storage_plugin=STORAGES[storage])
        self._writer.set_custom_data(*MARK)
        try:
            self._writer.open()
        except OSError as error:
            raise BagError(f'{path}: cannot be written: {error.strerror}') from error
        self._connections = {
            topic: self._writer.add_connection(
                topic, kind, typestore=_TYPES, offered_qos_profiles=[_QOS]
            )
            for topic, kind in topics.items()
        }

    def write(self, topic: str, log_time: int, cdr: bytes) -> None:
        """Add a message.

        :param topic: one of those given at the start.
        :param log_time: when it would have been recorded [ns], not negative.
        :param cdr: the serialized message, see :func:`canonical`.
        :raises BagWriteError: it cannot be written, as on a full disk.
        """
        with _explained():
            self._writer.write(self._connections[topic], log_time, cdr)

    def close(self) -> None:
        """Write the index and the metadata.

        :raises BagWriteError: as :meth:`write`.
        """
        with _explained():
            self._writer.close()


@contextlib.contextmanager
def _explained() -> Iterator[None]:
    """Errors of the library, which are those of the storage below, in one line."""
    try:
        yield
    except Exception as error:
        text = ' '.join(str(error).split()) or type(error).__name__
        raise BagWriteError(f'cannot be written: {text}') from error


def is_own_bag(path: Path) -> bool:
    """Whether a folder is a bag that :class:`BagWriter` has written, and holds nothing else."""
    try:
        metadata = yaml.safe_load((path / 'metadata.yaml').read_text())
        mark = metadata['rosbag2_bagfile_information']['custom_data'][MARK[0]]
        names = [p.name for p in path.iterdir() if p.is_file() and p.suffix in BAG_SUFFIXES]
        return mark == MARK[1] and {p.name for p in path.iterdir()} == {'metadata.yaml', *names}
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError):
        return False
