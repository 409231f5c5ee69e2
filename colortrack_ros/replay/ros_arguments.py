"""Lets rcl read ROS arguments, by nodes that nobody discovers."""

from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Sequence
import contextlib
import os
from pathlib import Path
import re
import threading
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.logging import get_logger_level
from rclpy.logging import LoggingSeverity
from rclpy.logging import set_logger_level
from rclpy.node import Node

from colortrack_ros.files import MAX_PARAMS_FILE
from colortrack_ros.files import read_file
from colortrack_ros.node_kit.runtime import refuse_params_files
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.parameters.owners import misspelled
from colortrack_ros.parameters.owners import owners_in

DISCOVERY = 'ROS_AUTOMATIC_DISCOVERY_RANGE'

RCL_ALONE = threading.Lock()
"""rcl reads state of the whole process, in which several threads may each replay a recording."""


class AskedNode(Node):
    """A node that exists only to learn which values rcl gives to a node of this name.

    :ivar given: the values of parameters from files and the command line, by full name.
    """

    def __init__(self, name: str, namespace: str, context: Context) -> None:
        self.given: dict[str, Any] = {}
        self._is_asked = False
        super().__init__(
            name,
            namespace=namespace,
            context=context,
            enable_rosout=False,
            start_parameter_services=False,
            automatically_declare_parameters_from_overrides=True,
        )

    def declare_parameters(
        self, namespace: str, parameters: Any, ignore_override: bool = False
    ) -> list[Any]:
        """Keep the given values, which rclpy declares first; declare the rest."""
        if not self._is_asked:
            self._is_asked = True
            # rcl cannot type an empty list
            self.given = {name: [] if value is None else value for name, value, _ in parameters}
            return []
        return super().declare_parameters(namespace, parameters, ignore_override)


@contextlib.contextmanager
def ros_context(args: Sequence[str]) -> Iterator[Context]:
    """A context with these ROS arguments; nobody discovers its nodes.

    :raises StartError: rcl cannot read the arguments or a file that they name.
    """
    with RCL_ALONE:
        before = os.environ.get(DISCOVERY)
        level = get_logger_level('rcl')
        set_logger_level('rcl', LoggingSeverity.FATAL)  # the exception also has what it logs
        os.environ[DISCOVERY] = 'OFF'
        context = Context()
        try:
            refuse_params_files(args)
            rclpy.init(args=['--ros-args', *args], context=context)
            yield context
        except (RuntimeError, ValueError) as error:  # from rclpy, about a params file
            text = re.sub(r'^failed to initialize rcl: |, at /\S+:\d+', '', str(error))
            raise StartError(' '.join(text.split())) from error
        finally:
            set_logger_level('rcl', level)
            os.environ.pop(DISCOVERY)
            if before is not None:
                os.environ[DISCOVERY] = before
            context.try_shutdown()


def namespaces_of(files: Iterable[Path], names: Sequence[str]) -> set[str]:
    """The namespaces in which params files name one of the nodes; the root is ``/``.

    :raises StartError: a file is not a params file.
    """
    owners = [owner for path in files for owner in _owners(path) if '*' not in owner]
    parts = [owner.rpartition('/') for owner in owners]
    return {namespace or '/' for namespace, _, name in parts if name in names}


def misspelled_in(files: Iterable[Path], names: Sequence[str]) -> list[str]:
    """For each params file and node whose name it may misspell, a line that says so.

    :raises StartError: a file is not a params file.
    """
    return [
        f'{path}: {told}'
        for path in files
        for owners in (_owners(path),)  # each file is read once
        for name in names
        if (told := misspelled(owners, name))
    ]


def _owners(path: Path) -> list[str]:
    """The full names of the nodes in a params file."""
    try:
        return owners_in(read_file(path, MAX_PARAMS_FILE))
    except ValueError as error:
        raise StartError(f'{path}: {error}') from error
