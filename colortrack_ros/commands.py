"""The executables: each imports its program, which takes a second, and ends without a traceback if
Ctrl-C or a missing package stops it.
"""

from collections.abc import Callable
from collections.abc import Iterable
import errno
from functools import partial
import importlib
import io
import os
import select
import signal
import sys

from colortrack_ros.signals import INTERRUPTED
from colortrack_ros.signals import PIPE_CLOSED

EXTRAS = {
    'demo': 'standalone,demo',
    'evaluate': 'standalone,replay',
    'replay': 'standalone,replay',
    'robot_demo': 'standalone,demo',
    'tune': 'standalone,replay',
    'tuner': 'standalone,replay,tuner',
}
"""What pip installs for each program; for the others ``standalone`` is enough."""


class Programs:
    """The programs of a room, as attributes: ``nodes.camera`` runs the node camera.

    :param name: of the room.
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, program: str) -> Callable[[], int]:
        return partial(run, f'{self._name}.{program}')


nodes, replay, tools, tuner = map(Programs, ('nodes', 'replay', 'tools', 'tuner'))


def run(module: str) -> int:
    """Import a program, and run it.

    :param module: its module in this package, such as ``nodes.camera``.
    :return: the exit status: that of the program, 1 if a package is missing, an argument cannot be
        read, or the output cannot be written, INTERRUPTED, or PIPE_CLOSED.
    """
    name = module.removesuffix('.main').rpartition('.')[2]
    heeded = signal.getsignal(signal.SIGINT) == signal.default_int_handler  # not ignored, as by &
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors='replace')  # a terminal may lack a character, such as ±
    try:
        if heeded:  # there is nothing to clean up yet
            signal.signal(signal.SIGINT, signal.SIG_DFL)
        _refuse_bytes()
        program = importlib.import_module(f'colortrack_ros.{module}')
        if heeded:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        status = _answered(name, str(program.__doc__)) if module.startswith('nodes.') else None
        status = _status_of(program.main) if status is None else status
        if sys.stdout is not None:  # as with >&-
            sys.stdout.flush()  # Python would do so as it exits, and fail with a traceback
        return status
    except KeyboardInterrupt:
        return INTERRUPTED
    except OSError as error:
        return _lost(name, error)
    except UnicodeError as error:
        print(f'{name}: {error}', file=sys.stderr)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition('.')[0] == __package__:
            raise
        need = f"in the folder of this package: pip install '.[{EXTRAS.get(name, 'standalone')}]'"
        print(f'{name}: {error}; source a ROS installation, or {need}', file=sys.stderr)
    return 1


def _status_of(main: Callable[[], int]) -> int:
    """The exit status of a program, also if argparse ends it, as after ``--help``: what that has
    printed still waits to be written.
    """
    try:
        return int(main())
    except SystemExit as end:
        if not isinstance(end.code, int | None):
            raise
        return end.code or 0


def _lost(name: str, error: OSError) -> int:
    """The exit status of a program whose output nobody reads, or for which there is no space.

    :param error: what it was; raised again if it was another.
    """
    output = sys.__stdout__.fileno() if sys.__stdout__ is not None else None  # as with >&-
    is_unread = isinstance(error, BrokenPipeError) and _has_no_reader(output)
    if not is_unread and error.errno != errno.ENOSPC:
        raise error
    if output is not None:  # what it still holds would fail again as Python exits
        os.dup2(os.open(os.devnull, os.O_WRONLY), output)
    if is_unread:
        return PIPE_CLOSED
    print(f'{name}: {error}', file=sys.stderr)
    return 1


def _has_no_reader(output: int | None) -> bool:
    """Whether a file descriptor is that of a pipe whose reader has seen enough, such as head."""
    if output is None:
        return False
    ends = select.poll()
    ends.register(output, select.POLLOUT)
    return any(state & select.POLLERR for _, state in ends.poll(0))


def _answered(name: str, text: str) -> int | None:
    """Answer a node's arguments that are no ROS arguments: with help, or with how to give them.

    :param text: what the node does.
    :return: the exit status; None if there are no such arguments, and the node is to run.
    """
    others = without_ros_arguments(sys.argv[1:])
    if not others:
        return None
    what, how = text.splitlines()[0], f'{name} --ros-args -p NAME:=VALUE --params-file FILE'
    if others[0] in ('-h', '--help'):
        print(f'{what}\nusage: {how} -r FROM:=TO; doc/parameters.md lists the parameters')
        return 0
    print(f'{what}\n{name}: got {others[0]!r}; expected {how} -r FROM:=TO', file=sys.stderr)
    return 2


def without_ros_arguments(words: Iterable[str]) -> list[str]:
    """What is left of a command line for the program itself.

    rclpy's ``remove_ros_args`` also opens the params files, and fails where they cannot be read;
    that is for the node to tell, once it has looked at them.
    """
    others, of_ros = [], False
    for word in words:
        if word == '--ros-args' or (of_ros and word == '--'):
            of_ros = word == '--ros-args'
        elif not of_ros:
            others.append(word)
    return others


def _refuse_bytes() -> None:
    """Refuse arguments that are not UTF-8 here, which ROS and OpenCV cannot take.

    :raises UnicodeError: one is not, or is not ASCII and the locale has another encoding.
    """
    encoding = sys.getfilesystemencoding()
    locale = f'this locale is {encoding}: set LC_ALL=C.UTF-8, and PYTHONUTF8=1 if that is 0'
    for word in sys.argv[1:]:
        content = os.fsencode(word)
        if (encoding != 'utf-8' and not word.isascii()) or content.decode(errors='replace') != word:
            need = locale if encoding != 'utf-8' else 'expected UTF-8; rename it'
            shown = content.decode(errors='backslashreplace').encode('ascii', 'backslashreplace')
            raise UnicodeError(f'{shown.decode()}: {need}')


if __name__ == '__main__':
    raise SystemExit(run(sys.argv.pop(1)))
