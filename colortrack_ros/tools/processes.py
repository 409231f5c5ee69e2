"""Runs nodes in their own processes, watched by a node in this one, for demos."""

import argparse
from collections.abc import Callable
import ctypes
from functools import partial
import os
from pathlib import Path
import random
import signal
import subprocess
import sys
import threading

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from colortrack_ros.node_kit.runtime import use_transport_profile
from colortrack_ros.signals import on_ending_signals

NODES_END = 8.0
"""How long the nodes may take to end after a signal [s]; they need at most 7.5 s."""

LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1
"""From <linux/prctl.h>."""


def add_demo_options(parser: argparse.ArgumentParser, seconds: float, text: str) -> None:
    """Add ``--seconds`` and ``--out``.

    :param seconds: the default, text: what they are.
    """
    parser.add_argument('--seconds', type=_seconds, default=seconds, help=text)
    parser.add_argument('--out', type=Path, default=Path('out'), help='folder for the results')


def _seconds(text: str) -> float:
    value = float(text)
    if not 0 < value < float('inf'):
        raise argparse.ArgumentTypeError(f'expected a positive number, got {text!r}')
    return value


class NodeEnded(Exception):
    """A node that others wait for has ended."""


class NodeGroup:
    """Starts nodes in a domain of their own on this machine, and ends them on exit.

    :param params: their params file.
    :param may_end: the node that may end before the others, after the last picture.
    """

    def __init__(self, params: str, may_end: str = '') -> None:
        self._params, self._may_end = params, may_end
        self._nodes: dict[str, subprocess.Popen[bytes]] = {}
        self._stop = threading.Event()

    def __enter__(self) -> 'NodeGroup':
        on_ending_signals(self._stop.set)
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
        os.environ.setdefault('ROS_DOMAIN_ID', str(random.randint(1, 100)))
        use_transport_profile()
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        self._executor = SingleThreadedExecutor()
        return self

    def __exit__(self, *_: object) -> None:
        """Shut the nodes down, and kill those that do not end."""
        for node in self._nodes.values():
            node.terminate()
        for node in self._nodes.values():
            try:
                node.wait(NODES_END)
            except subprocess.TimeoutExpired:
                node.kill()
                node.wait()

    @property
    def stopped(self) -> bool:
        """Whether a signal has asked to end."""
        return self._stop.is_set()

    def watch_with(self, node: Node) -> None:
        """Add a node of this process, which spin() spins."""
        self._executor.add_node(node)

    def start(self, name: str, *parameters: str) -> None:
        """Start a node in its own process, with additional parameters."""
        options = [word for parameter in parameters for word in ('-p', parameter)]
        command = [sys.executable, '-m', 'colortrack_ros.commands', f'nodes.{name}', '--ros-args']
        command += ['--params-file', self._params]
        bound = partial(_end_with, os.getpid())
        self._nodes[name] = subprocess.Popen(
            [*command, *options, '--log-level', 'warn'], preexec_fn=bound
        )

    def spin(self) -> None:
        """Receive messages for 0.1 s.

        :raises NodeEnded: a node has ended, so waiting for it would be futile.
        """
        self._executor.spin_once(timeout_sec=0.1)
        for name, node in self._nodes.items():
            if name != self._may_end and node.poll() is not None:
                raise NodeEnded(f'the node {name} has ended with status {node.returncode}')

    def spin_until(self, ready: Callable[[], bool]) -> None:
        """Spin until a condition holds, or a signal asks to end."""
        while not ready() and not self.stopped:
            self.spin()

    def status_of(self, name: str) -> int | None:
        """Exit status of a node; None while it is running."""
        return self._nodes[name].poll()


def _end_with(parent: int) -> None:
    """Ask Linux to send SIGTERM to this process when its parent ends.

    Ctrl-C reaches it as well: Python would end with a traceback until the node is there.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:  # it has already ended
        os._exit(1)


def told(error: OSError | NodeEnded) -> int:
    """Print why a demo has ended; returns its exit status."""
    reason = (
        f'{error.filename or "output"}: {error.strerror}' if isinstance(error, OSError) else error
    )
    print(f'demo: {reason}', file=sys.stderr)
    return 1
