"""The parameters of the tracker node."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from colortrack_ros.node_kit.diagnostics import HEALTH
from colortrack_ros.node_kit.intake import ORDER
from colortrack_ros.node_kit.live_parameters import own_values
from colortrack_ros.node_kit.topics import DEPTH
from colortrack_ros.node_kit.topics import topic
from colortrack_ros.node_kit.tracks_output import MARKER_SCALE
from colortrack_ros.node_kit.tracks_output import TRACKS_OUT
from colortrack_ros.parameters import build as build_config
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters.config import specs_of
from colortrack_ros.tracking import TrackerConfig

TABLE = ParameterTable(
    [
        *specs_of(TrackerConfig),
        MARKER_SCALE,
        *ORDER,
        topic('detections_topic', 'detections', 'the detections'),
        *TRACKS_OUT,
        DEPTH,
        *HEALTH,
    ]
)


@dataclass(frozen=True)
class TrackerSetup:
    """The configuration of the tracking room, and what the node itself needs."""

    config: TrackerConfig
    marker_scale: float
    reorder_window: float
    max_late: float
    detections_topic: str
    tracks_topic: str
    markers_topic: str


def build(values: Mapping[str, Any]) -> TrackerSetup:
    """The setup of a tracker.

    :raises ValueError: the values do not fit together; the reason names the parameter.
    """
    return TrackerSetup(build_config(TrackerConfig, values), **own_values(TrackerSetup, values))
