"""Reads files that parameters name, which may not end or block a node; and writes files whole."""

from collections.abc import Callable
import errno
from functools import partial
import os
from pathlib import Path
import queue
import stat
import tempfile
import threading
from typing import NoReturn
from typing import TypeVar

Answer = TypeVar('Answer')

TIME_TO_READ = 2.0
"""How long reading a file may take [s]: one on a dead network drive never ends."""

NEW_FILE = 0o644
"""Permissions of a file that was not there: all may read it, as umask has it nearly everywhere."""


def read_file(path: str | Path, most: int) -> bytes:
    """The content of a regular file, read in a thread of its own.

    :param most: size of the largest file that is read [bytes].
    :raises ValueError: there is no such file, it is a folder, a pipe or a device, is too large, or
        does not come in time; the reason says which.
    """
    try:
        return in_time(lambda: _read(Path(path), most), TIME_TO_READ)
    except TimeoutError as error:
        raise ValueError(f'{path}: could not be read {error}') from None
    except OSError as error:
        raise ValueError(f'{error.strerror}: {path}') from error
    except Exception as error:
        raise ValueError(f'{str(path)!r}: {error}') from error


def resolved(path: Path) -> Path:
    """Where a path leads to, through links.

    Of a link to itself Path.resolve raises RuntimeError before Python 3.13, and nothing since.

    :raises OSError: a link leads to itself.
    """
    found = Path(os.path.realpath(path))
    if found.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    return found


def write_file(path: Path, content: bytes) -> None:
    """Write a file as a whole or not at all: beside its place, then moved there.

    What was there keeps its permissions; where a link was, what it points to is replaced.

    :raises OSError: it cannot be written; what was there stays, and nothing is left beside it.
    """
    path = resolved(path)
    mode = stat.S_IMODE(path.stat().st_mode) if path.exists() else NEW_FILE
    handle, beside = tempfile.mkstemp(prefix='.', suffix='.new', dir=path.parent)
    try:
        with open(handle, 'wb') as file:
            file.write(content)
        os.chmod(beside, mode)
        os.replace(beside, path)
    except BaseException:
        Path(beside).unlink()
        raise


def in_time(call: Callable[[], Answer], seconds: float) -> Answer:
    """What a call returns or raises, made in a thread of its own, which is left behind if it hangs.

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
    # Without O_NONBLOCK, opening a pipe waits for its other end.
    with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), 'rb') as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise ValueError('expected a file, got a folder, a pipe or a device')
        content = file.read(most + 1)
    if len(content) > most:
        raise ValueError(f'expected a file of at most {most} bytes, this one is larger')
    return content
