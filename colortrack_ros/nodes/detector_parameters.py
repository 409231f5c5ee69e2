"""The parameters of the detector node."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.regions import Regions
from colortrack_ros.node_kit.diagnostics import HEALTH
from colortrack_ros.node_kit.intake import INTAKE
from colortrack_ros.node_kit.live_parameters import own_values
from colortrack_ros.node_kit.topics import DEPTH
from colortrack_ros.node_kit.topics import PICTURE_DEPTH
from colortrack_ros.node_kit.topics import topic
from colortrack_ros.parameters import build as build_config
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters.config import groups_of
from colortrack_ros.parameters.config import specs_of

TABLE = ParameterTable(
    [
        *specs_of(DetectorConfig),
        *INTAKE,
        topic('detections_topic', 'detections', 'the detections that are published'),
        topic('debug_topic', 'detector/mask', 'the mask, published while somebody subscribes'),
        PICTURE_DEPTH,
        DEPTH,
        *HEALTH,
    ],
    each={names: specs_of(group.each) for names, group in groups_of(DetectorConfig)},
)


@dataclass(frozen=True)
class DetectorSetup:
    """The configuration of the detection room, and what the node itself needs."""

    config: DetectorConfig
    max_lag: float
    reorder_window: float
    max_late: float
    image_topic: str
    image_transport: str
    detections_topic: str
    debug_topic: str


def build(values: Mapping[str, Any]) -> DetectorSetup:
    """The setup of a detector.

    :raises ValueError: the values do not fit together; the reason names the parameter.
    """
    config = build_config(DetectorConfig, values)
    Regions(config.regions, config.mask)  # reads the picture of the mask
    return DetectorSetup(config, **own_values(DetectorSetup, values))
