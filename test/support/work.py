"""Work for batches: other processes import it by name."""

import os
from pathlib import Path
import signal

from support.processors import stat_of
from support.waiting import wait_until

from colortrack_ros.batch import TaskError


def square(given, stop):
    """Says in a file that it was done."""
    with Path(given['folder'], 'done').open('a') as file:
        file.write(f'{given["n"]}\n')
    if given['n'] < 0:
        raise TaskError('expected a positive number')
    return {'square': given['n'] ** 2, 'one': 1 // given['n']}, ''


def die(given, stop):
    """Ends its process the first few times, as if there were no memory."""
    attempts = Path(given['folder'], f'attempts-{given["n"]}')
    with attempts.open('a') as file:
        file.write('.')
    if attempts.stat().st_size <= given['deaths']:
        os.kill(os.getpid(), signal.SIGKILL)
    return {'n': given['n']}, ''


def wait(given, stop):
    """Goes on when there is a file ``go``; leaves its process ID in another one."""
    folder = Path(given['folder'])
    (folder / f'pid-{given["n"]}-{os.getpid()}').touch()
    wait_until(lambda: stop.is_set() or (folder / 'go').exists())
    if stop.is_set():
        (folder / f'stopped-{given["n"]}').touch()
    return {'n': given['n']}, ''


def pids(folder):
    return {int(path.name.rpartition('-')[2]) for path in Path(folder).glob('pid-*')}


def is_alive(pid):
    try:
        state = stat_of(Path(f'/proc/{pid}'))[0]
    except (FileNotFoundError, ProcessLookupError):  # it ends before it is read, or as it is
        return False
    return state != 'Z'
