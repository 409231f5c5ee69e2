"""Many nodes in one process: their faults are the same, and they are there sooner."""

from pathlib import Path

import parameter_pages
from support.ros_domain import Process
from support.ros_domain import Ros
import yaml

PROGRAM = """
import importlib
from colortrack_ros.nodes import camera
from colortrack_ros.nodes import simulator
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.sources import open_source

# there may be no device 0
camera.open_source = lambda _, *rest: open_source('scene:single?width=64&height=48', *rest)

class Slow(simulator.Pacer):
    def pace(self, period):
        super().pace(1.0)

# what many simulators tell in time would keep all others busy
simulator.Pacer = Slow

def make(name, namespace):
    module = importlib.import_module('colortrack_ros.nodes.' + name)
    kind = ''.join(word.capitalize() for word in name.split('_')) + 'Node'
    return getattr(module, kind)(namespace=namespace)

raise SystemExit(run(lambda _: [make(*one) for one in {}]))
"""
NAMES = list(parameter_pages.NODES)


def start_nodes(ros: Ros, parameters: dict[str, dict], *arguments: str) -> Process:
    """Start nodes in one process.

    :param parameters: by the node's full name, such as /robot1/detector.
    :param arguments: further ROS arguments.
    """
    path = Path(ros.folder) / 'nodes.yaml'
    content = {node: {'ros__parameters': values} for node, values in parameters.items() if values}
    path.write_text(yaml.safe_dump(content, default_flow_style=False))
    nodes = [(n.rpartition('/')[2], n.rpartition('/')[0]) for n in parameters]
    options = ['--params-file', str(path)] if content else []
    return ros.start_code(PROGRAM.format(nodes), *options, *arguments)
