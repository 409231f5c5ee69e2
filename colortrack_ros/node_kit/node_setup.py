"""The parameters that every node has."""

from dataclasses import dataclass

from colortrack_ros.node_kit.diagnostics import HealthConfig
from colortrack_ros.node_kit.topics import QueueConfig
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter
from colortrack_ros.parameters import part


@dataclass(frozen=True)
class NodeSetup(Config):
    """The first parameters of every node."""

    strict: bool = parameter(
        False,
        'Whether the node ends when a value that is given on start is refused; otherwise it works '
        'with the default.',
        audience=EXPERT,
        read_only=True,
    )
    autostart: bool = parameter(
        True,
        'Whether the node works from its start on; otherwise a lifecycle manager configures and '
        'activates it.',
        audience=EXPERT,
        read_only=True,
    )
    queue: QueueConfig = part(QueueConfig)
    health: HealthConfig = part(HealthConfig)
