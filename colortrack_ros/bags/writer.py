"""Writing a rosbag2."""

from collections.abc import Mapping
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

from colortrack_ros.bags.errors import BagError
from colortrack_ros.bags.reader import BAG_SUFFIXES

STORAGES = {'mcap': StoragePlugin.MCAP, 'sqlite3': StoragePlugin.SQLITE3}
"""What a bag may be stored in; the first is what `ros2 bag record` takes."""

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
        """
        self._writer.write(self._connections[topic], log_time, cdr)

    def close(self) -> None:
        """Write the index and the metadata."""
        self._writer.close()


def is_only_a_bag(path: Path) -> bool:
    """Whether the path is a folder with the files of a bag and nothing else."""
    return path.is_dir() and all(
        p.name == 'metadata.yaml' or (p.is_file() and p.suffix in BAG_SUFFIXES)
        for p in path.iterdir()
    )
