"""The parameter tables of README.md, made from the tables of the nodes: ``make docs``."""

import re

from support.paths import ROOT

from colortrack_ros.nodes import camera_parameters
from colortrack_ros.nodes import contour_tracker_parameters
from colortrack_ros.nodes import detector_parameters
from colortrack_ros.nodes import overlay
from colortrack_ros.nodes import tracker_parameters
from colortrack_ros.nodes import window_tracker_parameters
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import Spec

README = ROOT / 'README.md'
NODES = {
    'camera': camera_parameters.TABLE,
    'detector': detector_parameters.TABLE,
    'tracker': tracker_parameters.TABLE,
    'overlay': overlay.TABLE,
    'window_tracker': window_tracker_parameters.TABLE,
    'contour_tracker': contour_tracker_parameters.TABLE,
}


def row(name: str, spec: Spec) -> str:
    default = 'none' if spec.optional else str(spec.default).replace("'", '') or "''"
    allowed = ' '.join(filter(None, [spec.range_text, spec.unit]))
    return f'| `{name}` | {spec.type_name} | `{default}` | {allowed} | {spec.description} |'


def table(parameters: ParameterTable) -> str:
    rows = ['| name | type | default | range, unit | meaning |', '|---|---|---|---|---|']
    rows += [row(name, spec) for name, spec in parameters.specs.items()]
    rows += [row(f'NAME.{name}', spec) for name, spec in parameters.each.items()]
    return '\n'.join(rows)


def written(text: str) -> str:
    """The text with each node's table between its two marks."""
    for node, parameters in NODES.items():
        mark = f'<!-- parameters of {node} -->'
        text = re.sub(
            f'{mark}.*?{mark}',
            lambda _, mark=mark, parameters=parameters: f'{mark}\n{table(parameters)}\n{mark}',
            text,
            flags=re.DOTALL,
        )
    return text


if __name__ == '__main__':
    README.write_text(written(README.read_text()))
