"""The library that reads and writes bags: rosbag2_py where ROS is installed, rosbags elsewhere."""

from collections.abc import Callable
from collections.abc import Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Protocol

from colortrack_ros.bags.bag_file import BagFile


def has_ros() -> bool:
    """Whether ROS's own library reads and writes bags."""
    return find_spec('rosbag2_py') is not None


class BagToWrite(Protocol):
    """A bag that is being written."""

    def write(self, topic: str, log_time: int, cdr: bytes) -> None:
        """Add a message to one of its topics."""

    def close(self) -> None:
        """Write the index and the metadata."""


def open_bag(path: Path) -> BagFile:
    """Open a bag, or one of its files.

    :raises Exception: it cannot be opened; the type depends on the library.
    """
    if has_ros():
        from colortrack_ros.bags.native import NativeFile

        return NativeFile(path)
    from colortrack_ros.bags.portable import PortableFile

    return PortableFile(path)


def create_bag(
    path: Path, topics: Mapping[str, str], storage: str, mark: tuple[str, str]
) -> BagToWrite:
    """Create a bag.

    :param topics: type of the messages of each topic, by the topic's name.
    :param storage: one of STORAGES.
    :param mark: key and value in its metadata.
    """
    if has_ros():
        from colortrack_ros.bags.native import NativeBag

        return NativeBag(path, topics, storage, mark)
    from colortrack_ros.bags.portable import PortableBag

    return PortableBag(path, topics, storage, mark)


def canonical(cdr: bytes, kind: str) -> bytes:
    """The same message with its padding set to zeros, where Fast CDR leaves what was in memory.

    Without rosbags 0.11.6 or newer, as on a robot, the message is returned unchanged.

    :param cdr: a serialized message.
    :param kind: its type.
    """
    rewrite = _rewriter()
    return rewrite(cdr, kind) if rewrite else cdr


@cache
def _rewriter() -> Callable[[bytes, str], bytes] | None:
    """The function that reserializes messages; looked up once, not for each message."""
    if find_spec('rosbags') is None:
        return None
    try:
        from colortrack_ros.bags.portable import rewritten
    except ImportError:  # an older rosbags, beside ROS
        return None
    return rewritten
