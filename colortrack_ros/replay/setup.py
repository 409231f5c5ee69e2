"""The command line of ``replay``, and the parameters that it and the params files give."""

import argparse
from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from colortrack_ros.bags import STORAGES
from colortrack_ros.batch import add_batch_options
from colortrack_ros.batch import FilesParser
from colortrack_ros.node_kit.detections_intake import DetectionsConfig
from colortrack_ros.node_kit.image_tracker import ImageTrackerSetup
from colortrack_ros.node_kit.intake import IntakeConfig
from colortrack_ros.node_kit.live_parameters import FOREIGN
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.nodes.camera_setup import CameraSetup
from colortrack_ros.nodes.contour_tracker import ContourTrackerSetup
from colortrack_ros.nodes.detector import DetectorSetup
from colortrack_ros.nodes.overlay import OverlaySetup
from colortrack_ros.nodes.tracker import TrackerSetup
from colortrack_ros.nodes.window_tracker import WindowTrackerSetup
from colortrack_ros.parameters import build
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.replay.ros_arguments import AskedNode
from colortrack_ros.replay.ros_arguments import namespaces_of
from colortrack_ros.replay.ros_arguments import ros_context

TOPICS = ('camera_info', 'detections', 'tracks', 'outlines', 'markers')
"""Topics of the node that publishes the tracks, empty if it has no such topic."""

ANYBODY = 'replay_asks_for_any_name'
"""A node name that only wildcards in a params file match."""

Tables = dict[str, tuple[ParameterTable, Callable[[Mapping[str, Any]], Any]]]


def _of(setup: type[Config]) -> tuple[ParameterTable, Callable[[Mapping[str, Any]], Any]]:
    return ParameterTable.of(setup), partial(build, setup)


TRACKERS: Tables = {
    'tracker': _of(TrackerSetup),
    'window_tracker': _of(WindowTrackerSetup),
    'contour_tracker': _of(ContourTrackerSetup),
}
"""The choices of ``--tracker``."""

TABLES: Tables = TRACKERS | {
    'camera': _of(CameraSetup),
    'detector': _of(DetectorSetup),
    'overlay': _of(OverlaySetup),
}


@dataclass(frozen=True)
class Setup:
    """The configuration that the nodes would have with the same parameters.

    :param node: name of the node that publishes the tracks.
    :param camera: values of the camera's parameters; empty if a bag takes its place.
    :param detector: None if the tracker takes no detections.
    :param tracker: of that node.
    :param topics: full names by ``image``, ``camera_info``, ``detections``, ``tracks``,
        ``outlines``, ``markers``, and, if the tracker needs it, ``odometry``; empty if there is
        none.
    """

    node: str
    camera: Mapping[str, Any]
    detector: DetectorSetup | None
    tracker: TrackerSetup | ImageTrackerSetup
    topics: Mapping[str, str]

    @property
    def intake(self) -> IntakeConfig:
        """How the node that subscribes to the pictures reads them."""
        if isinstance(self.tracker, ImageTrackerSetup):
            return self.tracker.intake
        return self.detector.intake if self.detector else IntakeConfig()

    @property
    def detections(self) -> DetectionsConfig | None:
        """How recorded detections are read, if they can replace pictures."""
        return self.tracker.detections if isinstance(self.tracker, TrackerSetup) else None


def parse(args: Sequence[str]) -> argparse.Namespace:
    """The command line; ROS arguments may stand after ``--ros-args``, as for a node."""
    return command_line().parse_args([w for w in args if w not in ('--ros-args', '--')])


def command_line() -> argparse.ArgumentParser:
    """The parser of ``replay``."""
    parser = FilesParser(
        'replay',
        description='Runs detector and tracker over recordings, every frame in the order of the '
        'stamps, and writes what the nodes would have published as new bags.',
        epilog='For several recordings, {} in the name of a file or folder stands for the name of '
        'each.',
    )
    add = parser.add_argument
    add(
        'inputs',
        nargs='+',
        metavar='input',
        help='a rosbag2 (folder, .mcap or .db3), a video, pictures, or scene:NAME; several, a '
        'folder of them, or @FILE with one a line',
    )
    add('--output', type=Path, help='folder of the new bag; default: the input with _tracks')
    add(
        '--tracker',
        choices=list(TRACKERS),
        default='tracker',
        help='whose tracks; default: tracker',
    )
    add('--storage', choices=list(STORAGES), default='mcap', help='default: mcap')
    add('--video', type=Path, help='write the overlay to this .mp4')
    add('--csv', type=Path, help='write the tracks to this file')
    add('--mot', type=Path, help='write the tracks to this file, in the form of MOTChallenge')
    add('--expect', type=Path, metavar='CSV', help='compare the tracks with those of this file')
    add('--force', action='store_true', help='overwrite what is there')
    add_ros_options(parser)
    add_batch_options(parser)
    return parser


def add_ros_options(parser: argparse.ArgumentParser) -> None:
    """Add the ROS arguments, which give parameters and topics."""
    ros = parser.add_argument_group('ROS arguments')
    ros.add_argument('--params-file', type=Path, action='append', default=[], metavar='YAML')
    ros.add_argument('-p', '--param', action='append', default=[], metavar='[NODE:]NAME:=VALUE')
    ros.add_argument('--topic', default='', help="the bag's topic to work on, images or detections")
    ros.add_argument('-r', '--remap', action='append', default=[], metavar='FROM:=TO')


def read_setup(arguments: argparse.Namespace, *, from_bag: bool) -> Setup:
    """The parameters from files and the command line, validated as the nodes do it.

    :param from_bag: whether the recording takes the place of the camera.
    :raises StartError: a value is refused, or a file cannot be read.
    """
    name = arguments.tracker
    with ros_context(_ros_args(arguments)) as context:
        namespace = _namespace(arguments, ('camera', 'detector', name)[from_bag:])
        nodes = {n: AskedNode(n, namespace, context) for n in ('camera', 'detector', name)}
        anybody = AskedNode(ANYBODY, namespace, context).given
        values = {name: _values(nodes[name], anybody, *TABLES[name])}
        detects = values[name].get('detections_topic', '') != ''
        for other, wanted in (('detector', detects), ('camera', not from_bag)):
            if wanted:
                values[other] = _values(nodes[other], anybody, *TABLES[other])

        def resolved(node: str, topic: str) -> str:
            given = values[node].get(f'{topic}_topic', '')
            return nodes[node].resolve_topic_name(given) if given else ''

        tracker = TRACKERS[name][1](values[name])
        told = isinstance(tracker, TrackerSetup) and tracker.config.ego_motion == 'odometry'
        return Setup(
            node=name,
            camera=values.get('camera', {}),
            detector=build(DetectorSetup, values['detector']) if detects else None,
            tracker=tracker,
            topics={topic: resolved(name, topic) for topic in TOPICS}
            | {
                'image': resolved('detector' if detects else name, 'image'),
                'odometry': resolved(name, 'odometry') if told else '',
            },
        )


def _ros_args(arguments: argparse.Namespace) -> list[str]:
    """The ROS arguments for rcl: files first, so that the command line overrides them.

    :raises StartError: one has no ``:=``; rcl's own message would be less clear.
    """
    words = [word for path in arguments.params_file for word in ('--params-file', str(path))]
    for option, form, texts in (
        ('-p', 'name:=value or node:name:=value', arguments.param),
        ('-r', 'from:=to or node:from:=to', arguments.remap),
    ):
        for text in texts:
            if not all(part.strip(':') for part in text.partition(':=')[::2]):
                raise StartError(f'{text}: expected {form}')
            words += option, text
    return words


def _namespace(arguments: argparse.Namespace, nodes: Sequence[str]) -> str:
    """The namespace that the parameters are for; rcl itself handles a remapping of it.

    :raises StartError: the parameters are for several.
    """
    found = namespaces_of(arguments.params_file, nodes)
    if any(text.partition(':=')[0].endswith('__ns') for text in arguments.remap):
        return '/'
    found |= {'/' for text in arguments.param if text.partition(':=')[0].split(':')[0] in nodes}
    if len(found) > 1:
        raise StartError(
            f'the parameters are for several namespaces, {", ".join(sorted(found))}: choose one, '
            'such as by -r __ns:=/robot1'
        )
    return found.pop() if found else '/'


def _values(
    node: AskedNode,
    anybody: Mapping[str, Any],
    table: ParameterTable,
    build: Callable[[Mapping[str, Any]], Any],
) -> dict[str, Any]:
    """The values of a node's parameters, defaults included.

    :param anybody: values that wildcards give to every node.
    """
    own = {}
    for name, value in node.given.items():
        is_for_any = name in anybody and anybody[name] == value
        if not name.startswith(FOREIGN) and not (is_for_any and _is_of_others(name, table)):
            own[name] = value
    values, refused = table.consistent(own, build)
    if refused:
        reasons = '; '.join(refused.values())
        raise StartError(f'parameters of {node.get_fully_qualified_name()} refused: {reasons}')
    return values


def _is_of_others(name: str, table: ParameterTable) -> bool:
    """Whether only nodes of other kinds have such a parameter."""
    return name not in table and any(name in other for other, _ in TABLES.values())
