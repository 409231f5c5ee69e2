"""Nodes without the second that importing takes each of them: forked where all is imported already.

Each is a process of its own that runs its program from the first line to the last.
"""

from collections.abc import Callable
import contextlib
import ctypes
import faulthandler
import functools
import gc
import importlib
from importlib.metadata import distribution
import inspect
import json
import os
from pathlib import Path
import pkgutil
import re
import select
import signal
import socket
import subprocess
import sys
import time
import warnings

from colortrack_ros import node_kit
from colortrack_ros.detection.cells import cell_bounds

ROOMS = ('contours', 'detection', 'drawing', 'messages', 'parameters', 'scenes', 'simulation',
         'sources', 'tracking', 'windows', 'world')  # fmt: skip
"""What takes long. Not the nodes: programs of tests replace what these import."""

AS_WELL = ('colortrack_ros.flow.backlog', 'colortrack_ros.flow.faults', 'colortrack_ros.flow.order',
           'colortrack_ros.flow.stage', 'colortrack_ros.signals',
           'colortrack_ros.world.locator', 'diagnostic_msgs.msg', 'geometry_msgs.msg',
           'lifecycle_msgs.msg', 'lifecycle_msgs.srv', 'nav_msgs.msg', 'rcl_interfaces.msg',
           'rcl_interfaces.srv', 'rosgraph_msgs.msg', 'sensor_msgs.msg', 'std_msgs.msg',
           'std_srvs.srv', 'type_description_interfaces.srv', 'visualization_msgs.msg')  # fmt: skip
"""What every node imports besides."""

TELL = signal.SIGUSR1
"""Makes a process that was forked print where each of its threads is, even one that keeps the
interpreter to itself."""

SIZE_OF_SIGSET = 128
"""Of sigset_t, on Linux [bytes]."""

THREADS = 3
"""Of a process that is forked: its own, and two in which LTTng waits for somebody who traces."""


@functools.cache
def entries() -> dict[str, str]:
    """Executables, and the module of each."""
    found = distribution('colortrack_ros').entry_points
    return {entry.name: f'colortrack_ros.{entry.attr}' for entry in found}


PATIENT = (
    'from colortrack_ros.node_kit import runtime; '
    'runtime.TIME_TO_END = runtime.TIME_OF_PYTHON = 100.0\n'
)
"""Gives a node the time to end, and its process to exit, that they take on a busy machine, or on
one that stands still for seconds: how much they have in earnest, test_start_and_end tests."""


def program_of(name: str) -> str:
    """What an executable does, as Python code, but for the time that it has to end."""
    return f'{PATIENT}import sys; from {entries()[name]} import main; sys.exit(main())'


class Fork:
    """A process that :class:`Nursery` has made, with what a Popen has.

    :ivar pid: of the process.
    :ivar returncode: None while it runs, minus the number of the signal that has killed it.
    """

    def __init__(self, pid: int, status: int) -> None:
        self.pid, self._status = pid, status
        self.returncode: int | None = None

    def poll(self) -> int | None:
        """The exit status, None while it runs."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.wait(0.0)
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        """The exit status.

        :raises subprocess.TimeoutExpired: it has not ended.
        """
        if self.returncode is None:
            if not select.select([self._status], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired(f'process {self.pid}', timeout or 0.0)
            self.returncode = int(os.read(self._status, 20))
            os.close(self._status)
        return self.returncode

    def send_signal(self, number: int) -> None:
        """Send a signal, unless it has ended."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def tell(self) -> None:
        """Have it print where its threads are."""
        self.send_signal(TELL)
        time.sleep(1.0)

    def kill(self) -> None:
        """Send SIGKILL."""
        self.send_signal(signal.SIGKILL)


class Nursery:
    """Starts the process that has everything imported, which ends with this one."""

    def __init__(self) -> None:
        self._socket, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with other:
            command = [sys.executable, '-m', 'support.forks', str(other.fileno())]
            folder = Path(__file__).parents[1]
            self._process = subprocess.Popen(command, cwd=folder, pass_fds=[other.fileno()])

    def start(self, code: str, argv: list[str], env: dict[str, str], log: Path) -> Fork:
        """Run a program in Python.

        :param argv: its own name, and the arguments.
        :param log: takes what it prints.
        """
        reading, writing = os.pipe()
        content = json.dumps([code, argv, env, os.getcwd(), str(log.absolute())]).encode()
        socket.send_fds(self._socket, [content], [writing])
        os.close(writing)
        return Fork(int(self._socket.recv(20)), reading)


@functools.cache
def nursery() -> Nursery:
    """That of this process."""
    return Nursery()


def _serve(requests: socket.socket) -> Callable[[dict[str, str]], None] | None:
    """Fork for each request; in the child return what it has to do, at the end nothing.

    The end is when the process that asks is gone: if it was killed, nothing else ends its nodes.
    """
    children: dict[int, tuple[int, int]] = {}
    while True:
        for ready in select.select([requests, *children], [], [])[0]:
            if ready in children:
                pid, status = children.pop(ready)
                code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
                with contextlib.suppress(OSError):  # nobody may wait for it
                    os.write(status, str(code).encode())
                os.close(status)
                os.close(ready)
                continue
            content, statuses, *_ = socket.recv_fds(requests, 1 << 20, 1)
            if not content:
                for pid, _ in children.values():
                    os.kill(pid, signal.SIGKILL)
                return None
            pid = _fork()
            if not pid:
                return functools.partial(_run, *json.loads(content))
            children[os.pidfd_open(pid)] = pid, statuses[0]
            requests.send(str(pid).encode())


def _fork() -> int:
    """Fork, and tell LTTng, which rclpy loads: else a child that ends looks for its threads."""
    signals = ctypes.create_string_buffer(SIZE_OF_SIGSET)
    before, in_parent, in_child = _hooks_of_tracing()
    before(signals)
    with warnings.catch_warnings():  # as of Python 3.12: of threads, which are LTTng's alone
        warnings.simplefilter('ignore', DeprecationWarning)
        pid = os.fork()
    (in_parent if pid else in_child)(signals)
    return pid


@functools.cache
def _hooks_of_tracing() -> list[Callable[[object], object]]:
    """What LTTng has to be told before a fork, and after it in the parent and in the child.

    These are the three of lttng-ust.h for programs that fork, as of its versions 2.12 and 2.13.
    """
    loaded = re.findall(r'/\S*liblttng-ust\S*', Path('/proc/self/maps').read_text())
    for path in sorted(set(loaded)):
        library = ctypes.CDLL(path)
        for prefix in ('ust', 'lttng_ust'):
            if hasattr(library, f'{prefix}_before_fork'):
                moments = ('before_fork', 'after_fork_parent', 'after_fork_child')
                return [getattr(library, f'{prefix}_{moment}') for moment in moments]
    return [lambda _: None] * 3


def _run(
    code: str, argv: list[str], env: dict[str, str], folder: str, log: str, own: dict[str, str]
) -> None:
    """Be what a process that is started so is.

    :param own: variables that modules set as they are imported, and libraries read later.
    """
    os.closerange(3, 1024)
    for number, path in enumerate((os.devnull, log, log)):
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND)
        os.dup2(file, number)
        os.close(file)
    os.environ.clear()
    os.environ.update(own | env)
    os.chdir(folder)
    sys.argv[:] = argv
    signal.signal(signal.SIGINT, signal.default_int_handler)
    faulthandler.register(TELL)
    exec(compile(code, '<string>', 'exec'), {'__name__': '__main__'})


def _load_type_support() -> None:
    """Load the C libraries of all messages imported here, and the parser that this imports."""
    for name in AS_WELL:
        for kind in vars(sys.modules[name]).values():
            if hasattr(type(kind), '__import_type_support__'):
                kind.__import_type_support__()


def _main() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    before = dict(os.environ)
    parts = [f'node_kit.{part.name}' for part in pkgutil.iter_modules(node_kit.__path__)]
    for name in (*(f'colortrack_ros.{room}' for room in (*ROOMS, *parts)), *AS_WELL):
        importlib.import_module(name)
    _load_type_support()
    cell_bounds()  # 40 ms of each detector's start
    assert len(os.listdir('/proc/self/task')) <= THREADS
    inspect.getmodule(inspect.currentframe())  # where each module is: rclpy asks as it first logs
    gc.freeze()  # a child that looks for garbage would copy all of it
    do = _serve(socket.socket(fileno=int(sys.argv[1])))
    if do:
        do({name: value for name, value in os.environ.items() if name not in before})


if __name__ == '__main__':
    _main()
