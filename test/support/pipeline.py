"""Source -> detector -> tracker without ROS, with the parameters of a params file."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from support.paths import ROOT
import yaml

from colortrack_ros.data import Detections
from colortrack_ros.data import Tracks
from colortrack_ros.detection import Detector
from colortrack_ros.nodes import detector_parameters
from colortrack_ros.nodes import tracker_parameters
from colortrack_ros.sources import open_source
from colortrack_ros.tracking import Tracker


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


def run(source: str, params: str = 'colortrack.yaml') -> Iterator[Step]:
    """What the three nodes make of each frame of a source."""
    given = parameters(params)
    setups = []
    for module, node in ((detector_parameters, 'detector'), (tracker_parameters, 'tracker')):
        values, refused = module.TABLE.consistent(given.get(node, {}), module.build)
        assert refused == {}
        setups.append(module.build(values).config)
    detector, tracker = Detector(setups[0]), Tracker(setups[1])
    frames = open_source(source)
    while (frame := frames.read()) is not None:
        detections = detector.detect(frame)
        yield Step(frame.image, detections, tracker.update(detections))
    frames.close()
