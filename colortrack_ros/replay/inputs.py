"""The recordings that the command line of ``replay`` names."""

from collections.abc import Iterator
from collections.abc import Sequence
from pathlib import Path

from colortrack_ros.bags import is_bag
from colortrack_ros.bags import is_own_bag
from colortrack_ros.sources.pictures import natural
from colortrack_ros.sources.pictures import PICTURE_SUFFIXES

VIDEO_SUFFIXES = ('.avi', '.m4v', '.mjpeg', '.mkv', '.mov', '.mp4', '.mpeg', '.mpg', '.webm')
"""Suffixes of the videos in a folder; a file that is named itself may have any suffix."""


def recordings_in(inputs: Sequence[str]) -> list[str]:
    """The inputs, with each folder of recordings replaced by its recordings in natural order.

    Bags that replay itself has written are left out, unless they are named.
    """
    return [one for name in inputs for one in (list(_within(Path(name))) or [name])]


def _within(folder: Path) -> Iterator[str]:
    """The recordings in a folder; none if the folder itself is one."""
    if not folder.is_dir() or is_bag_itself(folder) or _has_pictures(folder):
        return
    for path in sorted(folder.iterdir(), key=lambda path: natural(path.name)):
        if path.is_dir():
            wanted = _has_pictures(path) or (is_bag(path) and not is_own_bag(path))
        else:
            wanted = is_bag(path) or path.suffix.lower() in VIDEO_SUFFIXES
        if wanted:
            yield str(path)


def is_bag_itself(folder: Path) -> bool:
    """Whether a folder is one bag, not a folder of bags in one file each."""
    return is_bag(folder) and (
        (folder / 'metadata.yaml').is_file() or sum(is_bag(path) for path in folder.iterdir()) < 2
    )


def _has_pictures(folder: Path) -> bool:
    return any(path.suffix.lower() in PICTURE_SUFFIXES for path in folder.iterdir())
