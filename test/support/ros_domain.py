"""Real nodes in real processes, a domain for each test, all traffic on this machine."""

from collections.abc import Callable
import contextlib
import fcntl
import itertools
import os
from pathlib import Path
import re
import shutil
import signal
import socket
import subprocess
import sys
import time

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

from rcl_interfaces.srv import GetParameters
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.task import Future
from support.forks import Fork
from support.forks import nursery
from support.forks import PATIENT
from support.forks import program_of
from support.processors import stat_of
from support.processors import threads_of
from support.waiting import PATIENCE
from support.waiting import wait_until

from colortrack_ros.node_kit.runtime import use_transport_profile

use_transport_profile()
_domains = itertools.count(os.getpid())

NEW = 1.0
"""Age up to which a lock file may not be locked yet, between two calls of the system [s]."""


def executable(name: str) -> str:
    """The one of this environment, of the ament prefix, as for ``ros2 run``, or on the path."""
    prefixes = [Path(p) for p in os.environ.get('AMENT_PREFIX_PATH', '').split(':') if p]
    places = [Path(sys.executable).parent, *(p / 'lib/colortrack_ros' for p in prefixes)]
    found = shutil.which(name, path=os.pathsep.join(map(str, places))) or shutil.which(name)
    assert found, f'there is no executable {name}: install the package first'
    return found


def free_domain() -> tuple[int, socket.socket]:
    """A domain that no other test run has, and what keeps it ours.

    It is held by a name in the abstract namespace of Unix sockets, which all have in common that
    hear each other: also those in another container, with a /tmp of its own, on this network.
    """
    while True:
        domain = 1 + next(_domains) % 100
        lock = socket.socket(socket.AF_UNIX)
        try:
            lock.bind(f'\0colortrack_test_domain_{domain}')
        except OSError:
            lock.close()
        else:
            return domain, lock


def segments(pid: int) -> set[Path]:
    """The shared memory that a process has made, by the lock files that it keeps open."""
    files = [os.readlink(path) for path in Path(f'/proc/{pid}/fd').iterdir() if path.is_symlink()]
    names = [re.fullmatch('(/dev/shm/fastrtps_[0-9a-f]+)_el', file) for file in files]
    return {Path(name[1]) for name in names if name}


def remove_orphans() -> None:
    """Remove the shared memory of nodes that were killed, up to 70 MB each.

    Beside each segment there is a file that its node keeps locked.
    """
    for lock in Path('/dev/shm').glob('fastrtps_[0-9a-f]*_el'):
        with contextlib.suppress(OSError), lock.open() as file:
            if time.time() - os.fstat(file.fileno()).st_mtime > NEW:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                lock.with_name(lock.name.removesuffix('_el')).unlink(missing_ok=True)
                lock.unlink()


class Process:
    """A process, and the file that takes what it prints."""

    def __init__(self, popen: subprocess.Popen | Fork, log: Path) -> None:
        self.popen, self.log = popen, log

    @property
    def output(self) -> str:
        return self.log.read_text()

    def memory(self) -> int:
        """Its own [bytes]: what it has touched of its peers' grows when somebody stalls."""
        resident, shared = Path(f'/proc/{self.popen.pid}/statm').read_text().split()[1:3]
        return (int(resident) - int(shared)) * os.sysconf('SC_PAGE_SIZE')

    def work(self) -> float:
        """Processor time that it has used so far [s]."""
        fields = stat_of(Path(f'/proc/{self.popen.pid}'))
        return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')

    def wait_for(self, text: str, seconds: float = PATIENCE) -> None:
        wait_until(lambda: text in self.output, seconds, lambda: f'{text!r} in:\n{self.output}')

    def stop(self, number: signal.Signals = signal.SIGINT) -> int:
        """Send a signal and return the exit status."""
        self.popen.send_signal(number)
        return self.end()

    def end(self) -> int:
        """Wait for the end, and return the exit status."""
        try:
            return self.popen.wait(timeout=PATIENCE)
        except subprocess.TimeoutExpired as error:
            threads = threads_of(self.popen.pid)
            if isinstance(self.popen, Fork):
                self.popen.tell()
            raise AssertionError(f'has not ended:\n{threads}\n{self.output}') from error


def _options(parameters: dict[str, object]) -> list[str]:
    """ROS arguments that set parameters (YAML values)."""
    return [word for key, value in parameters.items() for word in ('-p', f'{key}:={value}')]


class Ros:
    """One ROS domain: starts processes, and listens and talks in this process."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.domain, self._lock = free_domain()
        self.processes: list[Process] = []
        self.context = Context()
        rclpy.init(context=self.context, domain_id=self.domain)
        self.node = Node('test', context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)

    def start(self, name: str, *arguments: str, **parameters: object) -> Process:
        """Start what an executable does with parameters (YAML values) and further ROS arguments."""
        return self._fork(name, program_of(name), *_options(parameters), *arguments)

    def start_code(
        self, code: str, *arguments: str, patient: bool = True, **parameters: object
    ) -> Process:
        """Start a Python program with parameters and further ROS arguments.

        :param patient: let a node have the time to end that it takes on a busy machine.
        """
        program = PATIENT + code if patient else code
        return self._fork('code', program, *_options(parameters), *arguments)

    def start_command(self, name: str, command: list[str]) -> Process:
        """Start any program in this domain, as a user does.

        :param name: of its log.
        """
        log, env = self._log(name), self._environment()
        with log.open('w') as file:
            popen = subprocess.Popen(
                command, env=env, stdin=subprocess.DEVNULL, stdout=file, stderr=subprocess.STDOUT
            )
        return self._keep(Process(popen, log))

    def _fork(self, name: str, code: str, *arguments: str) -> Process:
        log, argv = self._log(name), [name, '--ros-args', *arguments]
        return self._keep(Process(nursery().start(code, argv, self._environment(), log), log))

    def _log(self, name: str) -> Path:
        log = self.folder / f'{len(self.processes)}_{name}.log'
        log.touch()
        return log

    def _environment(self) -> dict[str, str]:
        return dict(os.environ, ROS_DOMAIN_ID=str(self.domain))

    def _keep(self, process: Process) -> Process:
        self.processes.append(process)
        return process

    def listen(self, kind: type, topic: str, *, reliable: bool = True, depth: int = 1000) -> list:
        """All messages on a topic from now on, a list that grows while :meth:`spin` runs."""
        messages: list = []
        qos = depth if reliable else qos_profile_sensor_data
        self.node.create_subscription(kind, topic, messages.append, qos)
        return messages

    def spin(self, condition: Callable[[], bool], seconds: float = PATIENCE) -> bool:
        """Spin until the condition holds; whether it did in time."""
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                return False
            self.executor.spin_once(timeout_sec=0.05)
        return True

    def is_silent(self, messages: list) -> bool:
        """Whether nothing comes into a list for a second, after what is still on its way."""
        messages.clear()
        return not self.spin(lambda: len(messages) > 0, 1.0)

    def settle(self) -> None:
        """Wait until the nodes know what there is: what they send before that is lost.

        A node learns of our ends in the order in which they were made, so once it answers a client
        it knows all the others. How far nodes know each other nobody tells: they get some time.
        """
        assert self.spin(self._all_named), self.outputs()
        for node in self._others():
            assert self._answers(*node), self.outputs()
        if len(self._others()) > 1:
            self.spin(lambda: False, 2.0)

    def _answers(self, name: str, namespace: str) -> bool:
        """Whether a node answers in time, or is gone: a killed one is known for a while yet."""
        service = f'{namespace.rstrip("/")}/{name}/get_parameters'
        client = self.node.create_client(GetParameters, service)
        futures: list[Future] = []
        for _ in range(60):  # a node that is slow to learn of the client answers nobody
            if client.service_is_ready():
                futures.append(client.call_async(GetParameters.Request()))
            over = self.spin(lambda: any(f.done() for f in futures), PATIENCE / 60)
            if over or (name, namespace) not in self._others():
                self.node.destroy_client(client)
                return True
        return False

    def _others(self) -> set[tuple[str, str]]:
        """Names and namespaces of the nodes that are known here: later than their topics are."""
        return set(self.node.get_node_names_and_namespaces()) - {(self.node.get_name(), '/')}

    def _all_named(self) -> bool:
        return len(self._others()) >= sum(p.popen.poll() is None for p in self.processes)

    def call(self, kind: type, name: str, request: object) -> object:
        """Call a service."""
        client = self.node.create_client(kind, name)
        wait_until(client.service_is_ready, what=lambda: f'{name}; {self.outputs()}')
        for _ in range(4):  # a node that is slow to learn of the client answers nobody
            future = client.call_async(request)
            if self.spin(future.done, PATIENCE / 4):
                break
        assert future.done(), f'{name}; {self.outputs()}'
        self.node.destroy_client(client)
        return future.result()

    def outputs(self) -> str:
        return '\n'.join(f'--- {p.log.name}\n{p.output}' for p in self.processes)

    def close(self) -> None:
        for process in self.processes:
            if process.popen.poll() is None:
                process.popen.send_signal(signal.SIGINT)
        for process in self.processes:
            try:
                process.popen.wait(timeout=20.0)
            except subprocess.TimeoutExpired:
                process.popen.kill()
                process.popen.wait()
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)
        self._lock.close()
