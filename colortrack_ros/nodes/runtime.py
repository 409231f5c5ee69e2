"""Start nodes in this process, spin them, and end them in order on SIGINT and SIGTERM."""

from collections.abc import Callable
from collections.abc import Sequence
import os
from pathlib import Path
import signal
import sys
import threading

from ament_index_python.packages import get_package_share_directory
from ament_index_python.packages import PackageNotFoundError
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

SIGNALS = (signal.SIGINT, signal.SIGTERM)
PATIENCE = 1.5
"""How long [s] the nodes have to end in order before the process ends without them."""


class StartError(Exception):
    """A node cannot start: what was given, what was expected and what to do, in one line."""


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


def run(
    make_nodes: Callable[[Callable[[], None]], Sequence[Node]], args: list[str] | None = None
) -> int:
    """Spin the nodes until SIGINT or SIGTERM.

    A node with a method ``close`` has it called before it is destroyed.

    :param make_nodes: called once ROS is there, with a function that ends the spinning.
    :return: the exit status: 0, or 1 when a node could not start.
    """
    use_transport_profile()
    stop = threading.Event()
    _on_signal(stop)
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy has no common class for its errors
        print(f'colortrack_ros: bad ROS arguments: {_one_line(error)}', file=sys.stderr)
        return 1
    nodes: Sequence[Node] = ()
    try:
        nodes = make_nodes(stop.set)
        _spin(nodes, stop)
    except (StartError, RuntimeError) as error:  # of rclpy, where a node cannot be made
        rclpy.logging.get_logger('colortrack_ros').fatal(_one_line(error))
        return 1
    finally:
        for node in nodes:
            getattr(node, 'close', lambda: None)()
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


def _spin(nodes: Sequence[Node], stop: threading.Event) -> None:
    executor = SingleThreadedExecutor()
    for node in nodes:
        executor.add_node(node)

    def wake() -> None:
        stop.wait()
        executor.wake()

    threading.Thread(target=wake, daemon=True).start()
    while not stop.is_set():
        executor.spin_once()
    executor.shutdown(timeout_sec=0.0)


def _on_signal(stop: threading.Event) -> None:
    """Have a signal set ``stop``, from a thread, so that it never hits a callback half way."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing)
    for number in SIGNALS:
        signal.signal(number, lambda *_: None)

    def wait() -> None:
        os.read(reading, 1)
        stop.set()
        threading.Event().wait(PATIENCE)
        os._exit(0)  # something does not return, such as a device that is being opened

    threading.Thread(target=wait, daemon=True).start()


def _one_line(error: Exception) -> str:
    return ' '.join(str(error).split())
