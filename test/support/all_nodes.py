"""Many nodes in one process: their faults are the same, and they are there sooner."""

import json
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

def make_all(finish):
    nodes = [make(*one) for one in {nodes}]
    {then}
    return nodes

raise SystemExit(run(make_all))
"""

WRITE_AND_END = """
    def write_and_end():
        import json
        values = [[n.get_parameter_or(name).value for name in given]
                  for n, given in zip(nodes, {given})]
        with open('{path}', 'w') as file:
            json.dump(values, file, default=list)
        finish(0)

    nodes[0].create_timer(0.0, write_and_end)  # called when all have started
"""
NAMES = list(parameter_pages.NODES)


def start_nodes(ros: Ros, parameters: dict[str, dict], *arguments: str) -> Process:
    """Start nodes in one process.

    :param parameters: by the node's full name, such as /robot1/detector.
    :param arguments: further ROS arguments.
    """
    return _start(ros, parameters, '', *arguments)


def values_taken(ros: Ros, parameters: dict[str, dict]) -> tuple[list[list], str]:
    """Start nodes in one process, which ends as soon as they have.

    Who asks 36 of them by services waits for rclpy, which visits all that each of them offers.
    :param parameters: as of :func:`start_nodes`.
    :return: the values of these parameters, node by node, and what the process has printed.
    """
    path = ros.folder / 'values.json'
    given = [list(values) for values in parameters.values()]
    process = _start(ros, parameters, WRITE_AND_END.format(given=given, path=path))
    assert process.end() == 0, process.output
    return json.loads(path.read_text()), process.output


def _start(ros: Ros, parameters: dict[str, dict], then: str, *arguments: str) -> Process:
    path = Path(ros.folder) / 'nodes.yaml'
    content = {node: {'ros__parameters': values} for node, values in parameters.items() if values}
    path.write_text(yaml.safe_dump(content, default_flow_style=False))
    nodes = [(n.rpartition('/')[2], n.rpartition('/')[0]) for n in parameters]
    options = ['--params-file', str(path)] if content else []
    return ros.start_code(PROGRAM.format(nodes=nodes, then=then), *options, *arguments)
