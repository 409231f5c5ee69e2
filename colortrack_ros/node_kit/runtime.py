"""Runs nodes in this process, and shuts them down in order on a signal."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Sequence
import contextlib
import gc
import itertools
import os
from pathlib import Path
import signal
import sys
import threading
import time

from ament_index_python.packages import get_package_share_directory
from ament_index_python.packages import PackageNotFoundError
import rclpy
from rclpy.duration import Duration
from rclpy.exceptions import ParameterException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from colortrack_ros.files import MAX_PARAMS_FILE
from colortrack_ros.files import read_file
from colortrack_ros.signals import ignore_ending_signals
from colortrack_ros.signals import on_ending_signals

TIME_TO_END = 1.5
"""How long [s] the nodes have to shut down before the process ends without them: a signal ends a
node within 2 s, and the interpreter takes the rest."""
TIME_TO_ARRIVE = 5.0
"""How long [s] the last messages have to arrive: Fast DDS resends lost ones after its heartbeat
period of 3 s."""
TIME_OF_ROS = 5.0
"""How long [s] ROS has after that to destroy the nodes: it takes less than 0.5 s for one node, and
more than 1.5 s for 24 in one process on a busy machine."""
TIME_OF_PYTHON = 5.0
"""How long [s] Python has after that to exit: it takes 0.2 s, and 1.3 s at a load of 15."""
HUNG = 124
"""Exit status of a process that had to end without its nodes: that of timeout(1)."""


TOLD = ('source', 'rate', 'colors', 'method')
"""Parameters whose values a node logs on start."""
OF_EVERY_NODE = frozenset(('/rosout', '/parameter_events', '/diagnostics', '/clock'))
"""Topics that every node has, and that are not logged."""


class StartError(Exception):
    """A node cannot start: in one line, what was given, what was expected, and what to do."""


END_OF_ROS = 'taking down ROS'


class _Life:
    """State of the process: whether it is to end, and its current stage.

    :ivar stop: set when it is to end.
    :ivar status: the exit status that a node has asked for; None if none has.
    :ivar stage: what it is doing, for the message if it does not end.
    """

    def __init__(self) -> None:
        self.stop = threading.Event()
        self.status: int | None = None
        self.stage = 'the start of the nodes'

    def finish(self, status: int) -> None:
        """End the process because a node has finished its work."""
        self.status = status
        self.stop.set()


def share_file(path: str) -> Path:
    """A file of the package, such as ``params/fastdds.xml``, installed or in the source tree."""
    try:
        installed = Path(get_package_share_directory('colortrack_ros')) / path
    except (PackageNotFoundError, OSError):  # OSError: no ROS installation
        installed = Path(sys.prefix) / 'share' / 'colortrack_ros' / path
    return installed if installed.exists() else Path(__file__).parents[2] / path


def use_transport_profile() -> None:
    """Make Fast DDS use the package's profile, unless the environment already configures it.

    Its default shared-memory segment is smaller than one picture, so more than 80 % of them would
    be lost.
    """
    names = (
        'FASTRTPS_DEFAULT_PROFILES_FILE',
        'FASTDDS_DEFAULT_PROFILES_FILE',
        'FASTDDS_BUILTIN_TRANSPORTS',
    )
    if not any(os.environ.get(name) for name in names):
        os.environ[names[0]] = str(share_file('params/fastdds.xml'))


def refuse_params_files(words: Iterable[str]) -> None:
    """Refuse params files on which rcl would block, such as a pipe.

    :param words: ROS arguments.
    :raises ValueError: one of the files is no regular file, is too large, or cannot be read.
    """
    for path in params_files(words):
        read_file(path, MAX_PARAMS_FILE)


def params_files(words: Iterable[str]) -> list[str]:
    """The params files that ROS arguments name."""
    return [path for option, path in itertools.pairwise(words) if option == '--params-file']


def run(
    make_nodes: Callable[[Callable[[int], None]], Sequence[Node]], args: list[str] | None = None
) -> int:
    """Spin the nodes until SIGINT, SIGTERM or SIGHUP.

    If a node has a method ``start``, it is called first; if it has ``close``, that is called before
    the node is destroyed, in reverse order.

    :param make_nodes: called once ROS is initialized. Its argument is a function that a node calls
        with an exit status when its work is done: all nodes then end, but first reliable
        subscribers get the last messages.
    :return: the exit status: that one, 0 after a signal, or 1 when a node could not start. After a
        signal, nodes that have not ended within TIME_TO_END end with the process, whose status is
        then HUNG; a process that cannot even exit is ended by SIGALRM. Further signals change
        nothing.
    """
    use_transport_profile()
    life = _Life()
    _on_signal(life)
    if not _initialize(args):
        return 1
    nodes: list[Node] = []
    try:
        nodes += make_nodes(life.finish)
        _start(nodes)
        life.stage = 'a callback'
        _spin(nodes, life.stop)
        life.stage = 'sending the last messages'
        if life.status is not None:
            _send_the_last(nodes)
    except (StartError, RuntimeError, ParameterException) as error:  # if rclpy creates no node
        rclpy.logging.get_logger('colortrack_ros').fatal(_one_line(error))
        return 1
    finally:
        _close(nodes, life)
        _take_down(nodes, life)
    return life.status or 0


def _initialize(args: list[str] | None) -> bool:
    """Initialize ROS; returns whether that worked, and prints the error if not."""
    try:
        refuse_params_files(sys.argv if args is None else args)
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy's errors have no common base class
        why = f'bad ROS arguments: {_one_line(error)}'
        if 'initialize logging' in why:  # as a service without HOME, or on a read-only disk
            why = f'{_one_line(error)}; set ROS_LOG_DIR to a folder that can be written to'
        print(f'colortrack_ros: {why}', file=sys.stderr)
        return False
    return True


def _start(nodes: Sequence[Node]) -> None:
    for node in nodes:
        getattr(node, 'start', lambda: None)()


def _close(nodes: list[Node], life: _Life) -> None:
    for node in reversed(nodes):
        life.stage = f'close() of {node.get_fully_qualified_name()}'
        getattr(node, 'close', lambda: None)()


def _take_down(nodes: list[Node], life: _Life) -> None:
    """Shut down ROS itself; the list holds the last references to the nodes."""
    life.stage = END_OF_ROS
    while nodes:
        nodes.pop().destroy_node()
    # The state machine of a managed node keeps its participant until then.
    gc.collect()
    rclpy.try_shutdown()
    # Python removes its handlers as it exits: another signal would kill the process.
    ignore_ending_signals()
    signal.setitimer(signal.ITIMER_REAL, TIME_OF_PYTHON)


def plan_of(node: Node) -> str:
    """One line with a node's source, rate, colors, and topics, as far as it has them."""
    names = [name for name in TOLD if node.has_parameter(name)]
    plan = [f'{name} {node.get_parameter(name).value}' for name in names]
    for verb, ends in (('takes', node.subscriptions), ('gives', node.publishers)):
        topics = sorted({end.topic_name for end in ends} - OF_EVERY_NODE)
        plan += [f'{verb} {", ".join(topics)}'] if topics else []
    return '; '.join(plan)


def _spin(nodes: Sequence[Node], stop: threading.Event) -> None:
    executor = SingleThreadedExecutor()
    for node in nodes:
        executor.add_node(node)

    def wake() -> None:
        stop.wait()
        executor.create_task(lambda: None)  # this ends spin_once

    waker = threading.Thread(target=wake, daemon=True)
    waker.start()
    # Not spin_until_future_complete, which leaks 300 bytes for every callback.
    while rclpy.ok() and not stop.is_set():
        executor.spin_once()
    stop.set()
    waker.join()
    executor.shutdown(timeout_sec=0.0)


def _send_the_last(nodes: Sequence[Node]) -> None:
    """Wait up to TIME_TO_ARRIVE until every reliable subscriber has acknowledged all messages."""
    end = time.monotonic() + TIME_TO_ARRIVE
    for publisher in [publisher for node in nodes for publisher in node.publishers]:
        left = max(end - time.monotonic(), 0.0)
        with contextlib.suppress(RuntimeError):  # from a middleware that does not support it
            publisher.wait_for_all_acked(Duration(seconds=left))


def _on_signal(life: _Life) -> None:
    """Make signals set ``life.stop``, from a thread, so that they never interrupt a callback."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing)
    on_ending_signals(lambda: None)

    def wait() -> None:
        os.read(reading, 1)
        life.stop.set()
        # no Python thread runs during exit, so Linux ends a process that hangs there
        signal.setitimer(signal.ITIMER_REAL, TIME_TO_END + TIME_OF_ROS + TIME_OF_PYTHON)
        seconds = TIME_TO_END
        time.sleep(TIME_TO_END)
        if life.stage == END_OF_ROS:
            seconds += TIME_OF_ROS
            time.sleep(TIME_OF_ROS)
        text = f'{life.stage} has not ended {seconds} s after a signal: the process ends now'
        with contextlib.suppress(OSError):  # the terminal is closed
            print(f'colortrack_ros: {text}', file=sys.stderr, flush=True)
        os._exit(HUNG)

    threading.Thread(target=wait, daemon=True).start()


def _one_line(error: Exception) -> str:
    return ' '.join(str(error).split())
