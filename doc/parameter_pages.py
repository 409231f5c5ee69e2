"""Writes ``parameters.md`` from the tables of the nodes: ``python doc/parameter_pages.py``."""

from collections.abc import Iterable
from pathlib import Path

from colortrack_ros.nodes.camera_setup import CameraSetup
from colortrack_ros.nodes.contour_tracker import ContourTrackerSetup
from colortrack_ros.nodes.detector import DetectorSetup
from colortrack_ros.nodes.follower import FollowerSetup
from colortrack_ros.nodes.locator import LocatorSetup
from colortrack_ros.nodes.overlay import OverlaySetup
from colortrack_ros.nodes.simulator import SimulatorSetup
from colortrack_ros.nodes.tracker import TrackerSetup
from colortrack_ros.nodes.window_tracker import WindowTrackerSetup
from colortrack_ros.parameters import DOCUMENT
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import Spec
from colortrack_ros.parameters import USER

PAGE = Path(__file__).with_name('parameters.md')

SETUPS = {
    'camera': CameraSetup,
    'detector': DetectorSetup,
    'tracker': TrackerSetup,
    'overlay': OverlaySetup,
    'locator': LocatorSetup,
    'follower': FollowerSetup,
    'simulator': SimulatorSetup,
    'window_tracker': WindowTrackerSetup,
    'contour_tracker': ContourTrackerSetup,
}
NODES = {name: ParameterTable.of(setup) for name, setup in SETUPS.items()}

AUDIENCES = {
    USER: 'For users',
    EXPERT: 'For experts',
    DOCUMENT: 'To reproduce a document',
}

INTRODUCTION = """\
<!-- Written by `python doc/parameter_pages.py`, which `make docs` runs. Edit the fields of the
     configurations instead. -->

# Parameters

Set parameters in YAML, with `-p` on the command line, or with `ros2 param set`. A bad value is
refused with a reason, and the old one stays in force; on start, the default. An int is accepted
where a float is expected. Topics, `source`, and queue depths can only be set on start.

For each node, the first table is for users, the second for experts who know the method, and the
third only reproduces one of the documents that this package implements. `ros2 param describe`
shows the same text. NAME stands for each name in a list such as `colors`.
"""


def row(name: str, spec: Spec) -> str:
    """One parameter as a row of a table."""
    default = 'none' if spec.optional else str(spec.default).replace("'", '') or "''"
    allowed = ' '.join(filter(None, [spec.range_text, spec.unit]))
    return f'| `{name}` | {spec.type_name} | `{default}` | {allowed} | {spec.description} |'


def rows(parameters: ParameterTable, audience: str) -> Iterable[str]:
    """The rows of a node's parameters that are for an audience."""
    everything = parameters.specs | {f'NAME.{n}': spec for n, spec in parameters.each.items()}
    return [row(name, spec) for name, spec in everything.items() if spec.audience == audience]


def page() -> str:
    """The whole page."""
    lines = [INTRODUCTION]
    for node, parameters in NODES.items():
        lines.append(f'## {node}\n')
        for audience, title in AUDIENCES.items():
            if found := rows(parameters, audience):
                lines.append(f'### {title}\n')
                lines.append('| name | type | default | range, unit | meaning |')
                lines.append('|---|---|---|---|---|')
                lines += [*found, '']
    return '\n'.join(lines)


if __name__ == '__main__':
    PAGE.write_text(page())
