"""A source of frames: the pictures of a bag."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from colortrack_ros.bags import BagError
from colortrack_ros.bags import BagReader
from colortrack_ros.bags import Topic
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.messages import MessageError
from colortrack_ros.node_kit.intake import IntakeConfig
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.replay.recordings import choose
from colortrack_ros.replay.recordings import MESSAGES
from colortrack_ros.sources import Source
from colortrack_ros.sources import SourceError
from colortrack_ros.sources.base import DEFAULT_RATE


class BagSource(Source):
    """One topic of images, raw or compressed, with the stamps of their headers.

    :param topic: its name; empty for the only one, or the camera's default.
    :raises SourceError: the bag cannot be read, or has no such topic.
    """

    live = False

    def __init__(self, path: Path, topic: str) -> None:
        try:
            self._reader = BagReader(path)
            pictures = [found for found in self._reader.topics if found.kind in MESSAGES]
        except BagError as error:
            raise SourceError(f'{path}: {error}') from error
        try:
            self._topic: Topic = choose(pictures, topic, f'/{IntakeConfig().image_topic}', '')
        except StartError as error:
            self._reader.close()
            raise SourceError(f'{path}: {error}') from error
        self.total = self._topic.size
        gaps = max(self.total - 1, 1)
        self.period = self._reader.duration // gaps or round(NANOSECONDS / DEFAULT_RATE)
        self.rewind()

    @staticmethod
    def accepts(spec: str) -> bool:
        """Never: a name does not tell whether a folder is a bag, its content does."""
        return False

    def read(self) -> Frame | None:
        """The next picture; None at the end.

        :raises SourceError: a picture is unreadable, or, at its end, the bag is broken.
        """
        try:
            _, cdr = next(self._messages)
            return IntakeConfig().frame_of(cdr, MESSAGES[self._topic.kind])
        except StopIteration:
            return None
        except BagError as error:
            raise SourceError(str(error)) from error
        except MessageError as error:
            raise SourceError(f'{self._topic.name}: {error}') from error

    def rewind(self) -> None:
        """Go back to the first picture."""
        self._messages: Iterator[tuple[int, Any]] = self._reader.messages(self._topic)

    def close(self) -> None:
        """Close the files."""
        self._reader.close()
