"""Reads files that users name, so that no file can hang or end a program; writes files
atomically.
"""

from collections.abc import Callable
from collections.abc import Iterator
import contextlib
import errno
from functools import partial
import os
from pathlib import Path
import queue
import stat
import tempfile
import threading
from typing import BinaryIO
from typing import NoReturn
from typing import TypeVar

Answer = TypeVar('Answer')

TIME_TO_READ = 2.0
"""How long reading a file may take [s]: on a dead network drive it never returns."""

NEW_FILE = 0o644
"""Permissions of a new file: readable by all, as with the usual umask of 022."""


MAX_PARAMS_FILE = 1 << 20
"""Size of the largest params file [bytes]: twenty times that of doc/parameters.md."""


def require_file(path: str | Path) -> None:
    """Refuse what is not a regular file, without opening it, which may block or have side effects.

    :raises OSError: there is no such file, or it is a folder, a pipe, a socket or a device.
    """
    if not stat.S_ISREG(os.stat(path).st_mode):
        reason = 'expected a file, got a folder, a pipe, a socket or a device'
        raise OSError(errno.EINVAL, reason, str(path))


def require_utf8(path: str | Path) -> None:
    """Refuse a name that is not UTF-8, for which OpenCV ends the process (SIGSEGV).

    :raises UnicodeError: it is not.
    """
    try:
        str(path).encode()
    except UnicodeError:
        raise UnicodeError('expected a name in UTF-8; rename it') from None


def open_file(path: str | Path) -> BinaryIO:
    """Open a regular file to read it.

    :raises OSError: as :func:`require_file`, or it cannot be opened.
    """
    require_file(path)
    return open(path, 'rb')


def read_file(path: str | Path, most: int) -> bytes:
    """The content of a regular file, read in a thread of its own.

    :param most: size of the largest file that is read [bytes].
    :raises ValueError: there is no such file, it is not a regular file, is too large, or cannot be
        read in time; the reason says which.
    """
    try:
        return in_time(lambda: _read(Path(path), most), TIME_TO_READ)
    except TimeoutError as error:
        raise ValueError(f'{path}: could not be read {error}') from None
    except OSError as error:
        raise ValueError(f'{error.strerror}: {path}') from error
    except Exception as error:
        raise ValueError(f'{str(path)!r}: {error}') from error


def read_params_file(path: str | Path) -> str:
    """The text of a params file.

    :raises ValueError: as :func:`read_file`, or it is not UTF-8.
    """
    return read_file(path, MAX_PARAMS_FILE).decode()


def resolved(path: Path) -> Path:
    """The target of a path, with links followed.

    For a link to itself, Path.resolve raises RuntimeError before Python 3.13 and nothing since.

    :raises OSError: a link points to itself.
    """
    found = Path(os.path.realpath(path))
    if found.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    return found


@contextlib.contextmanager
def named_in_errors(path: Path) -> Iterator[None]:
    """Name the file in an error of writing it: one of a full disk names none."""
    try:
        yield
    except OSError as error:
        if error.errno:
            error.filename = str(path)
        raise


def write_file(path: Path, content: bytes) -> None:
    """Write a file completely or not at all: to a temporary file beside it, which is then renamed.

    A file that is replaced keeps its permissions and, as far as possible, its owner; a link stays,
    and its target is replaced.

    :raises OSError: it cannot be written, or exists and is read-only or not a regular file; then
        the old file stays and nothing is left beside it.
    """
    path = resolved(path)
    old = path.stat() if path.exists() else None
    if old:
        require_file(path)
        if not os.access(path, os.W_OK):  # which its folder would allow
            raise OSError(errno.EACCES, os.strerror(errno.EACCES), str(path))
    mode = stat.S_IMODE(old.st_mode) if old else NEW_FILE
    handle, beside = tempfile.mkstemp(prefix='.', suffix='.new', dir=path.parent)
    try:
        with named_in_errors(path):
            with open(handle, 'wb') as file:
                file.write(content)
            if old:  # before the mode, which a change of the owner reduces
                with contextlib.suppress(OSError):  # only root may give files to others
                    os.chown(beside, old.st_uid, old.st_gid)
            os.chmod(beside, mode)
            os.replace(beside, path)
    except BaseException:
        Path(beside).unlink()
        raise


def in_time(call: Callable[[], Answer], seconds: float) -> Answer:
    """Make a call in a thread of its own, which is abandoned if it hangs.

    :raises TimeoutError: it takes longer than that many seconds.
    """
    answers: queue.Queue[Callable[[], Answer]] = queue.Queue(1)

    def answer() -> None:
        try:
            found = call()
            answers.put(lambda: found)
        except Exception as error:  # the caller raises it
            answers.put(partial(_raise, error))

    threading.Thread(target=answer, name='in_time', daemon=True).start()
    try:
        found = answers.get(timeout=seconds)
    except queue.Empty:
        raise TimeoutError(f'within {seconds:g} s') from None
    return found()


def _raise(error: Exception) -> NoReturn:
    raise error


def _read(path: Path, most: int) -> bytes:
    with open_file(path) as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise ValueError(f'expected a file of at most {most} bytes, this one is larger')
    return content
