"""Start nodes in this process, spin them, and end them in order on a signal."""

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
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from colortrack_ros.files import MAX_PARAMS_FILE
from colortrack_ros.files import read_file
from colortrack_ros.signals import ignore_ending_signals
from colortrack_ros.signals import on_ending_signals

TIME_TO_END = 1.5
"""How long [s] the nodes have to end in order before the process ends without them: a signal ends a
node within 2 s, of which the interpreter takes the rest."""
TIME_TO_ARRIVE = 5.0
"""How long [s] the last messages have to arrive: Fast DDS asks again for what is lost after its
heartbeat period of 3 s."""
TIME_OF_ROS = 5.0
"""How long [s] ROS has, from then on, to take down nodes that have ended: it takes less than 0.5 s
for one node, and more than 1.5 s for 24 in one process on a busy machine."""
TIME_OF_PYTHON = 5.0
"""How long [s] Python has after that to end itself: it takes 0.2 s, and 1.3 s at a load of 15."""
HUNG = 124
"""Exit status of a process that had to end without its nodes, that of timeout(1)."""


TOLD = ('source', 'rate', 'colors', 'method')
"""Parameters whose values a node tells at its start."""
OF_EVERY_NODE = frozenset(('/rosout', '/parameter_events', '/diagnostics', '/clock'))
"""Topics of every node, which say nothing about one."""


class StartError(Exception):
    """A node cannot start: what was given, what was expected and what to do, in one line."""


END_OF_ROS = 'taking down ROS'


class _Life:
    """Of the process: whether it shall end, and what it is at.

    :ivar stop: set when it shall end.
    :ivar status: the exit status that a node has ended it with; None if none has.
    :ivar stage: what it is at, for the message when it does not end.
    """

    def __init__(self) -> None:
        self.stop = threading.Event()
        self.status: int | None = None
        self.stage = 'the start of the nodes'

    def finish(self, status: int) -> None:
        """End it because a node's work is done."""
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
    """Have Fast DDS use the package's profile, unless the environment configures it already.

    Its own shared-memory segment is smaller than one picture, and then more than 80 % of them are
    lost.
    """
    names = (
        'FASTRTPS_DEFAULT_PROFILES_FILE',
        'FASTDDS_DEFAULT_PROFILES_FILE',
        'FASTDDS_BUILTIN_TRANSPORTS',
    )
    if not any(os.environ.get(name) for name in names):
        os.environ[names[0]] = str(share_file('params/fastdds.xml'))


def refuse_params_files(words: Iterable[str]) -> None:
    """Refuse params files that rcl would wait for, as for the other end of a pipe.

    :param words: ROS arguments.
    :raises ValueError: one of the files is no regular file, is too large, or cannot be read.
    """
    for option, path in itertools.pairwise(words):
        if option == '--params-file':
            read_file(path, MAX_PARAMS_FILE)


def run(
    make_nodes: Callable[[Callable[[int], None]], Sequence[Node]], args: list[str] | None = None
) -> int:
    """Spin the nodes until SIGINT, SIGTERM or SIGHUP.

    A node with a method ``start`` has it called at first, one with ``close`` before it is
    destroyed, in the opposite order.

    :param make_nodes: called once ROS is there, with a function by which a node ends all of them
        when its work is done, with the exit status; then reliable subscribers get the last messages
        first.
    :return: the exit status: that one, 0 after a signal, or 1 when a node could not start. After a
        signal, what has not ended within TIME_TO_END ends with the process, whose status is then
        HUNG; a process that cannot even end itself is ended by SIGALRM. Further signals change
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
    except (StartError, RuntimeError) as error:  # of rclpy, where a node cannot be made
        rclpy.logging.get_logger('colortrack_ros').fatal(_one_line(error))
        return 1
    finally:
        _close(nodes, life)
        _take_down(nodes, life)
    return life.status or 0


def _initialize(args: list[str] | None) -> bool:
    """Whether ROS could be initialized; if not, that is said."""
    try:
        refuse_params_files(sys.argv if args is None else args)
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy has no common class for its errors
        print(f'colortrack_ros: bad ROS arguments: {_one_line(error)}', file=sys.stderr)
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
    """End ROS itself: the nodes' last references are those in the list."""
    life.stage = END_OF_ROS
    while nodes:
        nodes.pop().destroy_node()
    # The state machine of a managed node keeps its participant until then.
    gc.collect()
    rclpy.try_shutdown()
    # Python takes its handlers away as it ends: one more signal would make an orderly end a death.
    ignore_ending_signals()
    signal.setitimer(signal.ITIMER_REAL, TIME_OF_PYTHON)


def plan_of(node: Node) -> str:
    """What a node will do, in a line: source, rate, colors, and topics, as far as it has them."""
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
        executor.create_task(lambda: None)  # which ends spin_once

    waker = threading.Thread(target=wake, daemon=True)
    waker.start()
    # Not spin_until_future_complete, which keeps 300 bytes of every callback.
    while rclpy.ok() and not stop.is_set():
        executor.spin_once()
    stop.set()
    waker.join()
    executor.shutdown(timeout_sec=0.0)


def _send_the_last(nodes: Sequence[Node]) -> None:
    """Wait until every reliable subscriber has acknowledged all messages, but not for long."""
    end = time.monotonic() + TIME_TO_ARRIVE
    for publisher in [publisher for node in nodes for publisher in node.publishers]:
        left = max(end - time.monotonic(), 0.0)
        with contextlib.suppress(RuntimeError):  # of a middleware that cannot tell
            publisher.wait_for_all_acked(Duration(seconds=left))


def _on_signal(life: _Life) -> None:
    """Have a signal set ``life.stop``, from a thread, so that it never hits a callback half way."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing)
    on_ending_signals(lambda: None)

    def wait() -> None:
        os.read(reading, 1)
        life.stop.set()
        # no thread of Python runs any more while it ends itself: then Linux ends it
        signal.setitimer(signal.ITIMER_REAL, TIME_TO_END + TIME_OF_ROS + TIME_OF_PYTHON)
        seconds = TIME_TO_END
        time.sleep(TIME_TO_END)
        if life.stage == END_OF_ROS:
            seconds += TIME_OF_ROS
            time.sleep(TIME_OF_ROS)
        text = f'{life.stage} has not ended {seconds} s after a signal: the process ends now'
        with contextlib.suppress(OSError):  # of a terminal that is closed
            print(f'colortrack_ros: {text}', file=sys.stderr, flush=True)
        os._exit(HUNG)

    threading.Thread(target=wait, daemon=True).start()


def _one_line(error: Exception) -> str:
    return ' '.join(str(error).split())
