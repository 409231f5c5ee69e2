"""The one folder that the page reads params files from and writes them to."""

from collections.abc import Sequence
import difflib
import hashlib
from pathlib import Path

from colortrack_ros.files import read_params_file
from colortrack_ros.files import resolved
from colortrack_ros.files import write_file

SUFFIXES = ('.yaml', '.yml')


class Folder:
    """The params files of one folder; no name leads outside it.

    :param root: an existing folder.
    """

    def __init__(self, root: Path) -> None:
        self.root = root.resolve()

    def names(self) -> list[str]:
        """The params files in it, not in subfolders; none if it has gone."""
        try:
            files = [p for p in self.root.iterdir() if p.suffix in SUFFIXES and p.is_file()]
        except OSError:
            return []
        return sorted(file.name for file in files)

    def read(self, name: str) -> str:
        """The text of a file.

        :raises ValueError: it does not exist, or must not be read.
        """
        return read_params_file(self.path(name))

    def read_or_empty(self, name: str) -> str:
        """The text of a file, empty if it does not exist yet.

        :raises ValueError: it must not be read.
        """
        return self.read(name) if self.exists(name) else ''

    def exists(self, name: str, suffixes: Sequence[str] = SUFFIXES) -> bool:
        """Whether a file exists.

        :raises ValueError: it must not be written.
        """
        return self.path(name, suffixes).exists()

    def write(self, name: str, text: str, suffixes: Sequence[str] = SUFFIXES) -> None:
        """Write a file completely or not at all.

        :param suffixes: the allowed ones.
        :raises ValueError: it must not or cannot be written.
        """
        path = self.path(name, suffixes)
        try:
            write_file(path, text.encode())
        except OSError as error:
            raise ValueError(f'{name}: {error.strerror}') from error

    def path(self, name: str, suffixes: Sequence[str] = SUFFIXES) -> Path:
        """The path of a file.

        :raises ValueError: it is outside the folder, in a folder that does not exist, or not YAML.
        """
        try:
            path = resolved(self.root / name)
        except (OSError, ValueError) as error:
            raise ValueError(f'path: {error}') from error
        if not path.is_relative_to(self.root) or not path.parent.is_dir():
            raise ValueError(f'path: expected a file in {self.root}, got {name!r}')
        if path.suffix not in suffixes:
            expected = ' or '.join(suffixes)
            raise ValueError(f'path: expected a name that ends in {expected}, got {name!r}')
        if path.exists() and not path.is_file():
            raise ValueError(f'path: expected a file, got {name!r}')
        return path


def difference(name: str, old: str, new: str) -> str:
    """The changes of a text, as ``diff -u`` shows them; empty if there are none."""
    lines = old.splitlines(), new.splitlines()
    return '\n'.join(difflib.unified_diff(*lines, f'{name} (now)', name, lineterm=''))


def digest(*texts: str) -> str:
    """A hash that tells whether texts have changed since somebody saw them."""
    return hashlib.sha256('\0'.join(texts).encode()).hexdigest()
