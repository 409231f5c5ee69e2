"""Reading a rosbag2."""

from collections import Counter
from collections.abc import Iterator
from collections.abc import Mapping
import contextlib
from pathlib import Path
from pathlib import PurePath
from typing import Any

import yaml

from colortrack_ros.bags.bag_file import BAG_SUFFIXES
from colortrack_ros.bags.bag_file import BagFile
from colortrack_ros.bags.bag_file import MAX_METADATA
from colortrack_ros.bags.bag_file import Topic
from colortrack_ros.bags.bag_file import ZSTD_SUFFIX
from colortrack_ros.bags.errors import BagError
from colortrack_ros.bags.library import open_bag
from colortrack_ros.files import read_file
from colortrack_ros.files import require_file

NOT_UNDERSTOOD = OSError, ValueError, KeyError, TypeError, AttributeError, yaml.YAMLError
"""Errors of a metadata.yaml that is not there, or not one."""


def is_bag(path: Path) -> bool:
    """Whether the path is a bag: one of its files, or a folder of them."""
    if path.is_dir():
        return any(p.name == 'metadata.yaml' or _is_part(p) for p in path.iterdir())
    return _is_part(path)


def _is_part(path: Path) -> bool:
    """Whether a file is one of a bag, by its name."""
    return path.name.removesuffix(ZSTD_SUFFIX).endswith(BAG_SUFFIXES)


class BagReader:
    """A rosbag2: a folder with its metadata.yaml, or a single .mcap or .db3 file.

    If the recording was cut short or is damaged, it reads what is left.

    :ivar topics: with at least one message, by name.
    :ivar duration: from the first message to the last [ns].
    :raises BagError: it cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        if path.suffix == ZSTD_SUFFIX:
            raise BagError(f'{path}: expected the folder of this bag, or the file after `zstd -d`')
        if path.is_dir() and not (path / 'metadata.yaml').is_file():
            raise BagError(
                f'{path}: a bag without its metadata.yaml; give one of its files (after '
                '`zstd -d`, if it is compressed), or run `ros2 bag reindex` on it'
            )
        metadata = _metadata(path)
        self._unnamed = ', '.join(_unnamed(path, metadata))
        self._expected: Counter[tuple[str, str]] | None = None
        with self._explained():
            for file in files_of(path):
                require_file(file)
            try:
                self._files: list[BagFile] = [_counted(open_bag(path))]
            except Exception as error:
                self._why = _one_line(error)
                self._expected = _recorded(metadata)
                if self._expected is None:
                    raise
                self._files = _salvaged(path)
                if not any(file.topics for file in self._files):
                    self.close()
                    raise
        sizes: Counter[tuple[str, str]] = Counter()
        for topic in [topic for file in self._files for topic in file.topics]:
            sizes[topic[:2]] += topic.size
        self.topics = [Topic(*names, size) for names, size in sorted(sizes.items())]
        self.duration = sum(file.duration for file in self._files)

    def messages(self, topic: Topic) -> Iterator[tuple[int, bytes]]:
        """Log time [ns] and serialized content of each message of a topic, in order of log times.

        :raises BagError: the file is broken or truncated; raised after all messages that could be
            read.
        """
        read, why = 0, ''
        for file in self._files:
            try:
                for message in file.messages(topic):
                    yield message
                    read += 1
            except Exception as error:  # a broken file can raise nearly anything
                why = why or _one_line(error)
        if trouble := self._lost(topic, read, why):
            raise BagError(f'{self._path}: {trouble}')

    def _lost(self, topic: Topic, read: int, why: str) -> str:
        """What to tell of a topic of which so many messages were read; empty if it is whole.

        :param why: why some could not be read.
        """
        if self._expected is None:
            if why:
                return (
                    f'{topic.size - read} of {topic.size} messages on {topic.name} cannot be read: '
                    f'{why}; {read} were read'
                )
            if read != topic.size:
                return (
                    f'metadata.yaml tells of {topic.size} messages on {topic.name}, '
                    f'{read} were read'
                )
            return self._unnamed and (
                f'its metadata.yaml does not tell of {self._unnamed}, of which no message was read;'
                ' run `ros2 bag reindex` on it'
            )
        expected = self._expected[topic[:2]]
        if read >= expected > 0:
            return f'the recording is damaged ({self._why}); all messages on {topic.name} were read'
        lost = f'{expected - read} of {expected}' if expected else 'an unknown number of'
        return (
            f'the recording was cut short: {lost} messages on {topic.name} are lost, '
            f'{read} were read'
        )

    def close(self) -> None:
        """Close the files."""
        for file in self._files:
            file.close()

    @contextlib.contextmanager
    def _explained(self) -> Iterator[None]:
        """Turn errors of the library into BagError: a broken file can raise nearly anything
        there.
        """
        try:
            yield
        except Exception as error:
            raise BagError(f'{self._path}: this bag cannot be read: {_one_line(error)}') from error


def _counted(file: BagFile) -> BagFile:
    """A bag whose topics have numbers of messages, as metadata.yaml may not tell.

    :raises ValueError: they have not; the bag is closed.
    """
    for topic in file.topics:
        if not isinstance(topic.size, int):
            file.close()
            raise ValueError(
                f'metadata.yaml: expected the number of messages on {topic.name}, got '
                f'{topic.size!r}'
            )
    return file


def _salvaged(path: Path) -> list[BagFile]:
    """The readable part of each file of a bag, by number; empty without the libraries for it."""
    try:
        from colortrack_ros.bags.salvage import salvage
    except ImportError:  # on a robot, which has only rosbag2_py
        return []
    files: list[BagFile] = []
    for part in sorted(files_of(path), key=lambda p: (len(p.name), p.name)):
        with contextlib.suppress(Exception):  # nothing of it can be read
            files.append(salvage(part))
    return files


def files_of(path: Path) -> list[Path]:
    """The files of a bag that hold its messages."""
    return [p for p in path.iterdir() if p.suffix in BAG_SUFFIXES] if path.is_dir() else [path]


def _metadata(path: Path) -> dict[str, Any]:
    """What the metadata.yaml of a bag tells; nothing if it is not there, or not understood."""
    with contextlib.suppress(*NOT_UNDERSTOOD):
        text = read_file(path / 'metadata.yaml', MAX_METADATA)
        return dict(yaml.safe_load(text)['rosbag2_bagfile_information'])
    return {}


def _unnamed(path: Path, metadata: Mapping[str, Any]) -> list[str]:
    """Files of a bag that its metadata.yaml does not name, as after a recorder that was killed."""
    with contextlib.suppress(*NOT_UNDERSTOOD):
        named = [PurePath(name).name for name in metadata['relative_file_paths']]
        # Players leave beside a compressed file what it holds.
        plain = {name.removesuffix(ZSTD_SUFFIX) for name in named}
        there = sorted(p.name for p in path.iterdir() if _is_part(p))
        return [name for name in there if name.removesuffix(ZSTD_SUFFIX) not in plain]
    return []


def _recorded(metadata: Mapping[str, Any]) -> Counter[tuple[str, str]] | None:
    """Number of messages of each topic and type, according to metadata.yaml.

    None if they are serialized in a way that nobody here can read: such a bag is not cut short.
    """
    counts: Counter[tuple[str, str]] = Counter()
    with contextlib.suppress(*NOT_UNDERSTOOD):
        for entry in metadata['topics_with_message_count']:
            topic = entry['topic_metadata']
            if topic['serialization_format'] != 'cdr':
                return None
            counts[topic['name'], topic['type']] += entry['message_count']
    return counts


def _one_line(error: Exception) -> str:
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return ' '.join(str(error).split()) or type(error).__name__
