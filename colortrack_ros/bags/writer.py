"""Writing a rosbag2."""

from collections.abc import Iterator
from collections.abc import Mapping
import contextlib
from pathlib import Path

import yaml

from colortrack_ros.bags.bag_file import BAG_SUFFIXES
from colortrack_ros.bags.bag_file import MAX_METADATA
from colortrack_ros.bags.errors import BagError
from colortrack_ros.bags.errors import BagWriteError
from colortrack_ros.bags.library import create_bag
from colortrack_ros.files import read_file

MARK = 'written_by', 'colortrack_ros'
"""Key and value in the metadata of bags that this package has written and may therefore replace."""


class BagWriter:
    """A rosbag2 as Jazzy writes it, with message definitions, type hashes and QoS.

    The same messages give the same bytes. The bag can be read only after :meth:`close`.

    :param path: a folder that does not exist yet.
    :param topics: type of the messages of each topic, by the topic's name.
    :param storage: a key of STORAGES.
    :raises BagError: the folder exists or cannot be created.
    """

    def __init__(self, path: Path, topics: Mapping[str, str], storage: str = 'mcap') -> None:
        if path.exists():
            raise BagError(f'{path}: is there already; it is not overwritten')
        try:
            self._bag = create_bag(path, topics, storage, MARK)
        except Exception as error:  # the libraries raise all kinds of errors
            reason = error.strerror if isinstance(error, OSError) else error
            raise BagError(f'{path}: cannot be written: {reason}') from error

    def write(self, topic: str, log_time: int, cdr: bytes) -> None:
        """Add a message.

        :param topic: one of those given at the start.
        :param log_time: when it would have been recorded [ns], not negative.
        :param cdr: the serialized message, see :func:`canonical`.
        :raises BagWriteError: it cannot be written, as on a full disk.
        """
        with _explained():
            self._bag.write(topic, log_time, cdr)

    def close(self) -> None:
        """Write the index and the metadata.

        :raises BagWriteError: as :meth:`write`.
        """
        with _explained():
            self._bag.close()


@contextlib.contextmanager
def _explained() -> Iterator[None]:
    """Turn errors of the library and its storage into one line."""
    try:
        yield
    except Exception as error:
        text = ' '.join(str(error).split()) or type(error).__name__
        raise BagWriteError(f'cannot be written: {text}') from error


def is_own_bag(path: Path) -> bool:
    """Whether a folder is a bag that :class:`BagWriter` has written, and holds nothing else."""
    try:
        metadata = yaml.safe_load(read_file(path / 'metadata.yaml', MAX_METADATA))
        mark = metadata['rosbag2_bagfile_information']['custom_data'][MARK[0]]
        names = [p.name for p in path.iterdir() if p.is_file() and p.suffix in BAG_SUFFIXES]
        return mark == MARK[1] and {p.name for p in path.iterdir()} == {'metadata.yaml', *names}
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError):
        return False
