"""The parameters of the tracker node."""

from collections.abc import Mapping
from dataclasses import dataclass
from dataclasses import fields
from typing import Any

from colortrack_ros.nodes.parameters import ParameterTable
from colortrack_ros.nodes.parameters import Spec
from colortrack_ros.nodes.topics import DEPTH
from colortrack_ros.nodes.topics import topic
from colortrack_ros.tracking import TrackerConfig

_DEFAULT = TrackerConfig()


def _spec(
    name: str,
    description: str,
    unit: str = '',
    minimum: float | None = None,
    maximum: float | None = None,
) -> Spec:
    return Spec(name, getattr(_DEFAULT, name), description, unit, minimum, maximum)


TABLE = ParameterTable(
    [
        _spec(
            'max_time_since_update',
            'A track that has not been measured for longer is deleted.',
            's',
            0.0,
            3600.0,
        ),
        Spec(
            'marker_scale',
            0.01,
            'Size of a pixel in the markers.',
            unit='m/px',
            minimum=1e-9,
            maximum=1e3,
        ),
        topic('detections_topic', 'detections', 'the detections'),
        topic('tracks_topic', 'tracks', 'the tracks that are published'),
        topic('markers_topic', 'tracks/markers', 'the markers that are published'),
        DEPTH,
    ]
)


@dataclass(frozen=True)
class TrackerSetup:
    """The configuration of the tracking room, and what the node itself needs."""

    config: TrackerConfig
    marker_scale: float


def build(values: Mapping[str, Any]) -> TrackerSetup:
    """The setup of a tracker.

    :raises ValueError: the values do not fit together; the reason names the parameter.
    """
    config = TrackerConfig(**{field.name: values[field.name] for field in fields(TrackerConfig)})
    return TrackerSetup(config, values['marker_scale'])
