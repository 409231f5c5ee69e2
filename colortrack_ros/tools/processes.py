"""Nodes as processes of their own, for the demos."""

from collections.abc import Collection
from collections.abc import Mapping
import ctypes
from functools import partial
import os
import signal
import subprocess
import sys

NODES_END = 8.0
"""How long the nodes may take to end after a signal [s]: on their own they need at most 6.5 s."""

LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1
"""Of <linux/prctl.h>."""


class NodeEnded(Exception):
    """One of the nodes has ended before the camera did."""


def start_node(name: str, params: str, *parameters: str) -> subprocess.Popen[bytes]:
    """Start a node in its own process, with a params file and further parameters."""
    options = [word for parameter in parameters for word in ('-p', parameter)]
    code = f'from colortrack_ros.nodes.{name} import main; raise SystemExit(main())'
    command = [sys.executable, '-c', code, '--ros-args', '--params-file', params, *options]
    bound = partial(_end_with, os.getpid())
    return subprocess.Popen([*command, '--log-level', 'warn'], preexec_fn=bound)


def _end_with(parent: int) -> None:
    """Have Linux send SIGTERM to this process when the one that started it has ended."""
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:  # it has ended already
        os._exit(1)


def check_nodes(nodes: Mapping[str, subprocess.Popen[bytes]]) -> None:
    """Raise NodeEnded if a node has ended: the demo would wait for its messages in vain."""
    for name, node in nodes.items():
        if name != 'camera' and node.poll() is not None:
            raise NodeEnded(f'the node {name} has ended with status {node.returncode}')


def end_nodes(nodes: Collection[subprocess.Popen[bytes]]) -> None:
    """End the nodes in order, and kill those that do not end."""
    for node in nodes:
        node.send_signal(signal.SIGINT)
    for node in nodes:
        try:
            node.wait(NODES_END)
        except subprocess.TimeoutExpired:
            node.kill()
            node.wait()
