"""The parameters of the tracker node."""

from collections.abc import Iterable
from collections.abc import Mapping
from dataclasses import dataclass
from dataclasses import fields
from typing import Any

from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.node_kit.diagnostics import HEALTH
from colortrack_ros.node_kit.intake import ORDER
from colortrack_ros.node_kit.parameters import own_values
from colortrack_ros.node_kit.parameters import ParameterTable
from colortrack_ros.node_kit.parameters import Spec
from colortrack_ros.node_kit.topics import DEPTH
from colortrack_ros.node_kit.topics import topic
from colortrack_ros.node_kit.tracks_output import MARKER_SCALE
from colortrack_ros.node_kit.tracks_output import TRACKS_OUT
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.association import ASSOCIATORS

_DEFAULT = TrackerConfig()


def _spec(
    name: str,
    description: str,
    unit: str = '',
    minimum: float | None = None,
    maximum: float | None = None,
    choices: Iterable[str] = (),
) -> Spec:
    """A row whose default is that of the room."""
    default = getattr(_DEFAULT, name)
    default = list(default) if isinstance(default, tuple) else default
    return Spec(name, default, description, unit, minimum, maximum, tuple(choices))


TABLE = ParameterTable(
    [
        _spec(
            'max_time_since_update',
            'A track that has not been measured for longer is deleted.',
            's',
            0.0,
            3600.0,
        ),
        _spec(
            'process_noise',
            'Standard deviation of the acceleration that the motion model does not know (sigma_s). '
            '0 learns it from the innovations.',
            'px/s^2',
            0.0,
            1e6,
        ),
        _spec(
            'acceleration',
            'Known in advance, along u and v, such as gravity; for the motion models '
            'known_acceleration and switched_pair.',
            'px/s^2',
            -1e6,
            1e6,
        ),
        _spec('maneuvers', 'Whether objects may turn or bounce; how often is learned.'),
        _spec(
            'measurement_noise',
            'Standard deviation of a measured position, where a detection brings no covariance '
            '(sigma_w).',
            'px',
            1e-3,
            1e3,
        ),
        _spec(
            'detection_covariance',
            'Whether the covariance that a detection brings is used; if not, measurement_noise '
            'holds for all.',
        ),
        _spec(
            'centroid_bias',
            'Standard deviation of what is systematic about centroids, on each axis, which no '
            'filter averages out; adds to the published covariance.',
            'px',
            0.0,
            1e3,
        ),
        _spec('color_gating', 'Whether a track takes only detections of its own color.'),
        _spec(
            'use_boxes',
            'Whether the bounding boxes tell when an object is cut or merged with another.',
        ),
        _spec('motion_model', 'How objects move between frames.', choices=MOTION_MODELS),
        _spec('associator', 'How detections are given to tracks.', choices=ASSOCIATORS),
        _spec(
            'initial_speed',
            'Standard deviation of the velocity of a new track, and of what a maneuver changes, on '
            'each axis. 0 learns it from the tracks.',
            'px/s',
            0.0,
            1e6,
        ),
        _spec(
            'detection_probability',
            'That a visible object is detected in a frame.',
            '',
            0.01,
            0.999,
        ),
        _spec(
            'clutter_density',
            'Detections a frame that belong to no track yet, false or new; sets the gate and the '
            'cost of a miss. 0 learns it.',
            '1/px^2',
            0.0,
            1.0,
        ),
        _spec(
            'gating',
            'Whether detections that are unlikely to be of a track are refused; if not, any may be '
            'of any, and none is left over while a track is.',
        ),
        _spec('confirm_hits', 'Detections that confirm a track, among', '', 1, 100),
        _spec('confirm_window', 'its first so many frames.', '', 1, 100),
        _spec(
            'max_position_sigma',
            'A track whose position is known less well is deleted.',
            'px',
            1e-3,
            1e9,
        ),
        _spec(
            'image_size',
            'Width and height of the picture; a track that has left it is deleted. 0 for not '
            'known.',
            'px',
            0,
            100_000,
        ),
        _spec(
            'max_dt',
            'A longer jump of the stamps starts the tracker afresh.',
            's',
            1e-3,
            3600.0,
        ),
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
    config = TrackerConfig(**{field.name: values[field.name] for field in fields(TrackerConfig)})
    return TrackerSetup(config, **own_values(TrackerSetup, values))
