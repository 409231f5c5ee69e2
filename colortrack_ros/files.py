"""Reads files that parameters name: nothing in them may end or block a node."""

import os
from pathlib import Path
import queue
import stat
import threading

TIME_TO_READ = 2.0
"""How long reading a file may take [s]: one on a dead network drive never ends."""


def read_file(path: str | Path, most: int) -> bytes:
    """The content of a regular file, read in a thread of its own.

    :param most: size of the largest file that is read [bytes].
    :raises ValueError: there is no such file, it is a folder, a pipe or a device, is too large, or
        does not come in time; the reason says which.
    """
    answers: queue.Queue[bytes | Exception] = queue.Queue(1)

    def answer() -> None:
        try:
            answers.put(_read(Path(path), most))
        except Exception as error:  # the caller raises it
            answers.put(error)

    threading.Thread(target=answer, name='read_file', daemon=True).start()
    try:
        found = answers.get(timeout=TIME_TO_READ)
    except queue.Empty:
        raise ValueError(f'{path}: could not be read within {TIME_TO_READ:g} s') from None
    if isinstance(found, OSError):
        raise ValueError(f'{found.strerror}: {path}') from found
    if isinstance(found, Exception):
        raise ValueError(f'{str(path)!r}: {found}') from found
    return found


def _read(path: Path, most: int) -> bytes:
    # Without O_NONBLOCK, opening a pipe waits for its other end.
    with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), 'rb') as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise ValueError('expected a file, got a folder, a pipe or a device')
        content = file.read(most + 1)
    if len(content) > most:
        raise ValueError(f'expected a file of at most {most} bytes, this one is larger')
    return content
