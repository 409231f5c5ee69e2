"""Source -> detector -> tracker without ROS, with the parameters of a params file."""

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from support.paths import ROOT
import yaml

from colortrack_ros.chain import ColorTracker
from colortrack_ros.data import Detections
from colortrack_ros.data import Tracks
from colortrack_ros.nodes.detector import DetectorSetup
from colortrack_ros.nodes.tracker import TrackerSetup
from colortrack_ros.parameters import build
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.sources import open_source


class Step(NamedTuple):
    image: NDArray[np.uint8]
    detections: Detections
    tracks: Tracks


def flat(tree: dict, prefix: str = '') -> dict:
    """The parameters of a YAML mapping by their full names."""
    values = {}
    for key, value in tree.items():
        if isinstance(value, dict):
            values.update(flat(value, f'{prefix}{key}.'))
        else:
            values[prefix + key] = value
    return values


def parameters(name: str) -> dict[str, dict]:
    """The parameters of each node in a file of params/."""
    nodes = yaml.safe_load((ROOT / 'params' / name).read_text())
    return {
        node.removeprefix('/**/'): flat(content['ros__parameters'])
        for node, content in nodes.items()
    }


def build_checked(setup: type[Config], given: dict) -> Config:
    """The setup of a node of these parameters, every one of which has to be accepted."""
    values, refused = ParameterTable.of(setup).consistent(given, partial(build, setup))
    assert refused == {}
    return build(setup, values)


def run(source: str, params: str = 'colortrack.yaml') -> Iterator[Step]:
    """What the three nodes make of each frame of a source."""
    given = parameters(params)
    track = ColorTracker(
        build_checked(DetectorSetup, given.get('detector', {})).config,
        build_checked(TrackerSetup, given.get('tracker', {})).config,
    )
    frames = open_source(source)
    for frame in frames:
        tracks = track(frame)
        yield Step(frame.image, track.detections, tracks)
    frames.close()
