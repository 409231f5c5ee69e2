"""What the command line of ``replay`` and the files that it names ask for."""

import argparse
from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
import contextlib
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from colortrack_ros.bags import STORAGES
from colortrack_ros.node_kit.image_tracker import ImageTrackerSetup
from colortrack_ros.node_kit.intake import IntakeConfig
from colortrack_ros.node_kit.live_parameters import FOREIGN
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.nodes.camera import CameraSetup
from colortrack_ros.nodes.contour_tracker import ContourTrackerSetup
from colortrack_ros.nodes.detector import DetectorSetup
from colortrack_ros.nodes.overlay import OverlaySetup
from colortrack_ros.nodes.tracker import TrackerSetup
from colortrack_ros.nodes.window_tracker import WindowTrackerSetup
from colortrack_ros.parameters import build
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.replay.params_file import Given
from colortrack_ros.replay.params_file import namespaces_of
from colortrack_ros.replay.params_file import read_assignment
from colortrack_ros.replay.params_file import read_params_file

Tables = dict[str, tuple[ParameterTable, Callable[[Mapping[str, Any]], Any]]]


def _of(setup: type[Config]) -> tuple[ParameterTable, Callable[[Mapping[str, Any]], Any]]:
    return ParameterTable.of(setup), partial(build, setup)


TRACKERS: Tables = {
    'tracker': _of(TrackerSetup),
    'window_tracker': _of(WindowTrackerSetup),
    'contour_tracker': _of(ContourTrackerSetup),
}
"""What ``--tracker`` may name."""

TABLES: Tables = TRACKERS | {
    'camera': _of(CameraSetup),
    'detector': _of(DetectorSetup),
    'overlay': _of(OverlaySetup),
}


@dataclass(frozen=True)
class Setup:
    """What the nodes of the same parameters would have.

    :param node: the name of the one that publishes the tracks.
    :param camera: values of the camera's parameters; empty where a bag is its own camera.
    :param detector: None where the tracker takes no detections.
    :param tracker: of that node.
    :param topics: full names by ``image``, ``camera_info``, ``detections``, ``tracks``,
        ``outlines``, and ``markers``; empty where there is none.
    """

    node: str
    camera: Mapping[str, Any]
    detector: DetectorSetup | None
    tracker: TrackerSetup | ImageTrackerSetup
    topics: Mapping[str, str]

    @property
    def intake(self) -> IntakeConfig:
        """How the node that takes the pictures reads them."""
        if isinstance(self.tracker, ImageTrackerSetup):
            return self.tracker.intake
        return self.detector.intake if self.detector else IntakeConfig()

    @property
    def takes_detections(self) -> bool:
        """Whether recorded detections will do in place of pictures."""
        return isinstance(self.tracker, TrackerSetup)


def parse(args: Sequence[str]) -> argparse.Namespace:
    """The command line; ROS arguments may stand after ``--ros-args``, as for a node."""
    parser = argparse.ArgumentParser(
        prog='replay',
        description='Runs detector and tracker over a recording, every frame in the order of the '
        'stamps, and writes what the nodes would have published as a new bag.',
    )
    add = parser.add_argument
    add('input', help='a rosbag2 (folder, .mcap or .db3), a video, pictures, or scene:NAME')
    add('--output', type=Path, help='folder of the new bag; default: the input with _tracks')
    add(
        '--tracker',
        choices=list(TRACKERS),
        default='tracker',
        help='whose tracks; default: tracker',
    )
    add('--storage', choices=list(STORAGES), default='mcap', help='default: mcap')
    add('--topic', default='', help="the bag's topic to work on, images or detections")
    add('--video', type=Path, help='write the overlay to this .mp4')
    add('--csv', type=Path, help='write the tracks to this file')
    add('--mot', type=Path, help='write the tracks to this file, in the form of MOTChallenge')
    add('--expect', type=Path, metavar='CSV', help='compare the tracks with those of this file')
    add('--force', action='store_true', help='overwrite what is there')
    ros = parser.add_argument_group('ROS arguments')
    ros.add_argument('--params-file', type=Path, action='append', default=[], metavar='YAML')
    ros.add_argument('-p', '--param', action='append', default=[], metavar='[NODE:]NAME:=VALUE')
    ros.add_argument('-r', '--remap', action='append', default=[], metavar='FROM:=TO')
    return parser.parse_args([word for word in args if word not in ('--ros-args', '--')])


def read_setup(arguments: argparse.Namespace, *, from_bag: bool) -> Setup:
    """The parameters that the files and the command line give, checked as the nodes check them.

    :param from_bag: whether the recording takes the place of the camera.
    :raises StartError: a value is refused, or a file cannot be read.
    """
    name = arguments.tracker
    try:
        given = [item for path in arguments.params_file for item in read_params_file(path)]
        given += [read_assignment(text) for text in arguments.param]
        namespace, remaps = _read_remaps(arguments.remap)
        nodes = ('camera', 'detector', name)[from_bag:]
        namespace = namespace or _only_namespace(given, nodes)
    except ValueError as error:
        raise StartError(str(error)) from error

    def values_of(node: str) -> dict[str, Any]:
        return _values(f'{namespace.rstrip("/")}/{node}', given, *TABLES[node])

    def resolved(node: str, topic: str) -> str:
        full = _full_name(values[node][f'{topic}_topic'], namespace, node)
        for of, old, new in remaps:
            if of in ('', node) and _full_name(old, namespace, node) == full:
                return _full_name(new, namespace, node)
        return full

    values = {name: values_of(name)}
    detects = values[name].get('detections_topic', '') != ''
    if detects:
        values['detector'] = values_of('detector')
    return Setup(
        node=name,
        camera={} if from_bag else values_of('camera'),
        detector=build(DetectorSetup, values['detector']) if detects else None,
        tracker=TRACKERS[name][1](values[name]),
        topics={
            'image': resolved('detector' if detects else name, 'image'),
            'camera_info': (
                resolved(name, 'camera_info') if 'camera_info_topic' in values[name] else ''
            ),
            'detections': resolved(name, 'detections') if detects else '',
            'tracks': resolved(name, 'tracks'),
            'outlines': resolved(name, 'outlines') if 'outlines_topic' in values[name] else '',
            'markers': resolved(name, 'markers'),
        },
    )


def _values(
    node: str,
    given: Iterable[Given],
    table: ParameterTable,
    build: Callable[[Mapping[str, Any]], Any],
) -> dict[str, Any]:
    """The values of a node's parameters, defaults included."""
    own = {
        item.name: item.value
        for item in given
        if item.is_for(node)
        and not item.name.startswith(FOREIGN)
        and not _is_of_others(item, table)
    }
    values, refused = table.consistent(own, build)
    if refused:
        reasons = '; '.join(refused.values())
        raise StartError(f'parameters of {node} refused: {reasons}')
    return values


def _is_of_others(item: Given, table: ParameterTable) -> bool:
    """Whether a value that is given to nodes of any name is meant for other kinds of nodes."""
    return (
        item.is_for_any
        and not _knows(table, item.name)
        and any(_knows(other, item.name) for other, _ in TABLES.values())
    )


def _knows(table: ParameterTable, name: str) -> bool:
    with contextlib.suppress(ValueError):
        table.find(name)
        return True
    return False


def _read_remaps(texts: Sequence[str]) -> tuple[str, list[tuple[str, str, str]]]:
    """The namespace, empty when none is given, and (node or empty, from, to) of each topic."""
    namespace, remaps = '', []
    for text in texts:
        left, separator, new = text.partition(':=')
        node, _, old = left.rpartition(':')
        if not separator or not old or not new:
            raise ValueError(f'{text}: expected from:=to or node:from:=to')
        if old == '__ns':
            namespace = new
        else:
            remaps.append((node, old, new))
    return namespace, remaps


def _only_namespace(given: Sequence[Given], nodes: Sequence[str]) -> str:
    """The namespace that the parameters are for, where nobody says."""
    namespaces = namespaces_of(given, nodes)
    if len(namespaces) > 1:
        raise ValueError(
            f'the parameters are for several namespaces, {", ".join(sorted(namespaces))}: choose '
            'one, such as by -r __ns:=/robot1'
        )
    return namespaces.pop() if namespaces else '/'


def _full_name(name: str, namespace: str, node: str) -> str:
    if name.startswith('/'):
        return name
    base = namespace.rstrip('/')
    return f'{base}/{node}/{name[2:]}' if name.startswith('~/') else f'{base}/{name}'
