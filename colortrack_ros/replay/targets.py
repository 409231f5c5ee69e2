"""The places that ``replay`` writes to: an old file stays until its replacement is complete."""

from collections.abc import Iterable
from collections.abc import Sequence
import errno
import glob
from pathlib import Path
import shutil
import tempfile

from colortrack_ros.bags import is_own_bag
from colortrack_ros.files import resolved
from colortrack_ros.node_kit.runtime import StartError

PREFIX = '.replay-'
"""Prefix of the folders for files that are not complete yet."""


class Targets:
    """The folder of the bag and further files: written to temporary folders beside their places,
    and moved at the end.

    :param bag: the folder of the new bag.
    :param files: the other outputs.
    :param inputs: files, folders and patterns that are read.
    :param force: whether existing files may be replaced.
    :param task: a unique name for the temporary folders; those left by an attempt that was killed
        are removed.
    :raises StartError: a file exists and may not be replaced, or the place is not writable.
    """

    def __init__(
        self,
        bag: Path,
        files: Sequence[Path],
        inputs: Iterable[str | Path],
        *,
        force: bool,
        task: str = '',
    ) -> None:
        read = [path for name in inputs for path in _paths(str(name))]
        for path in (bag, *files):
            _check(path, read, force=force)
        for path in files:
            if (path.exists() and not path.is_file()) or not path.parent.is_dir():
                raise StartError(f'{path}: expected the name of a file in a folder that is there')
            if resolved(bag) in resolved(path).parents:
                raise StartError(f'{path}: is in {bag}, which is the folder of the new bag alone')
        if len({resolved(path) for path in (bag, *files)}) <= len(files):
            raise StartError('two outputs have one name; expected one for each')
        if bag.exists() and not is_own_bag(bag):
            raise StartError(
                f'{bag}: is not a bag that replay has written, or not only; it is not overwritten'
            )
        self._staged: dict[Path, Path] = {}
        self._prefix = PREFIX + task
        for path in (bag, *files) if task else ():
            for folder in resolved(path).parent.glob(f'{self._prefix}*'):
                shutil.rmtree(folder, ignore_errors=True)

    def staged(self, path: Path) -> Path:
        """Where to write a file: in a temporary folder beside its place."""
        target = resolved(path)  # a link stays; its target is replaced
        target.parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=self._prefix, dir=target.parent))
        self._staged[target] = folder / target.name
        return self._staged[target]

    def commit(self) -> None:
        """Move everything that was written to its place.

        :raises OSError: something has been removed since; then nothing is moved.
        """
        for target, staged in self._staged.items():
            if not staged.parent.is_dir():
                reason = 'its folder was removed while it was written'
                raise OSError(errno.ENOENT, reason, str(target))
        for target, staged in self._staged.items():
            if not staged.exists():  # a video without a frame
                continue
            if target.is_dir():
                target.rename(staged.parent / 'before')
            staged.replace(target)
        self.discard()

    def discard(self) -> None:
        """Remove everything that has not been moved."""
        for staged in self._staged.values():
            shutil.rmtree(staged.parent, ignore_errors=True)
        self._staged.clear()


def _paths(name: str) -> list[Path]:
    """The path of a name, or those that match a pattern."""
    return [resolved(Path(path)) for path in (glob.glob(name) or [name])]


def _check(path: Path, read: Iterable[Path], *, force: bool) -> None:
    """Raise StartError if a path is an input, contains one, or is part of one."""
    target, there = resolved(path), path.exists()
    for source in read:
        is_part = there and source in target.parents
        if target == source or target in source.parents or is_part or _is_same(path, source):
            raise StartError(f'{path}: is the input; it is not overwritten')
    if there and not force:
        raise StartError(f'{path}: is there already; --force overwrites it')


def _is_same(path: Path, source: Path) -> bool:
    """Whether two names are hard links to the same file, or one of a file in an input folder."""
    if not path.is_file():
        return False
    files = source.rglob('*') if source.is_dir() else (source,)
    return any(file.is_file() and path.samefile(file) for file in files)
