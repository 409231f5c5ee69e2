"""The parameters of the detector node."""

from collections.abc import Mapping
from dataclasses import dataclass
from dataclasses import replace
from typing import Any

from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.config import CHOICES
from colortrack_ros.detection.config import RANGES
from colortrack_ros.detection.reference import PRESETS
from colortrack_ros.detection.regions import Region
from colortrack_ros.detection.regions import Regions
from colortrack_ros.node_kit.diagnostics import HEALTH
from colortrack_ros.node_kit.intake import INTAKE
from colortrack_ros.node_kit.live_parameters import own_values
from colortrack_ros.node_kit.topics import DEPTH
from colortrack_ros.node_kit.topics import PICTURE_DEPTH
from colortrack_ros.node_kit.topics import topic
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import Spec

_DEFAULT = DetectorConfig()


def _spec(name: str, description: str, unit: str = '') -> Spec:
    """A row with the default, the range and the choices of the room."""
    low, high = RANGES.get(name, (None, None))
    choices = tuple(CHOICES.get(name, ()))
    return Spec(name, getattr(_DEFAULT, name), description, unit, low, high, choices)


TABLE = ParameterTable(
    [
        Spec(
            'colors',
            [color.name for color in _DEFAULT.colors],
            'Names of the reference colors; a detection carries the index into this list.',
        ),
        Spec(
            'min_area',
            _DEFAULT.min_area,
            'Blobs with fewer pixels are dropped.',
            unit='px',
            minimum=1,
            maximum=1_000_000_000,
        ),
        Spec(
            'max_area',
            _DEFAULT.max_area,
            'Blobs with more pixels are dropped.',
            unit='px',
            minimum=1,
            maximum=1_000_000_000,
        ),
        Spec(
            'erosion_size',
            _DEFAULT.erosion_size,
            'Side of the structuring element of the erosion, odd; 1 leaves the mask as it is.',
            unit='px',
            minimum=1,
            maximum=99,
        ),
        Spec(
            'opening_size',
            _DEFAULT.opening_size,
            'Side of the structuring element of the opening, odd; 1 leaves the mask as it is.',
            unit='px',
            minimum=1,
            maximum=99,
        ),
        Spec(
            'closing_size',
            _DEFAULT.closing_size,
            'Side of the structuring element of the closing before the erosion, odd; 1 leaves the '
            'mask as it is.',
            unit='px',
            minimum=1,
            maximum=99,
        ),
        Spec(
            'regions',
            (str,),
            'Names of the regions to look in or to ignore.',
        ),
        Spec('mask', '', 'Path of a picture that is dark where not to look; empty for none.'),
        _spec('split', 'Whether blobs of touching objects are cut at their necks.'),
        _spec('min_aspect', "Least ratio of a blob's minor to its major axis."),
        _spec('min_extent', "Least ratio of a blob's area to that of its box."),
        _spec('min_circularity', 'Least likeness of a blob to a disc; a ball is above 0.9.'),
        _spec('min_solidity', "Least ratio of a blob's area to that of its convex hull."),
        _spec('grow', 'How many times the tolerance of the pixels that a blob grows by; 1: none.'),
        _spec('white_balance', 'Whether the mean of each channel is kept as in the first frame.'),
        _spec(
            'follow_light',
            'How far the reference colors may follow slow changes of what is found.',
            'CIELAB units',
        ),
        _spec('method', 'How objects are told from the rest.'),
        _spec(
            'moving_only',
            'Of method color: whether what stands still is dropped, so that furniture of the '
            'reference colors is not found.',
        ),
        _spec('channel', 'Of method channel_difference: the channel from which others are taken.'),
        _spec('channel_threshold', 'Of method channel_difference: what has to be left.', 'levels'),
        _spec('background_model', 'Of method background: how the background is learned.'),
        _spec(
            'difference_threshold',
            'Of moving_only and the median background: what differs by more from it moves.',
            'levels',
        ),
        _spec('blur_sigma', 'Of method background: the Gaussian before the threshold.', 'px'),
        _spec('learn_seconds', 'How long what moves is taken out of a new background.', 's'),
        _spec('threads', 'Threads that work on a picture; 2 help at 3840x2160, with OpenCV 5.'),
        *INTAKE,
        topic('detections_topic', 'detections', 'the detections that are published'),
        topic('debug_topic', 'detector/mask', 'the mask, published while somebody subscribes'),
        PICTURE_DEPTH,
        DEPTH,
        *HEALTH,
    ],
    each={
        'colors': [
            Spec(
                'lab',
                (float,),
                'The reference color [L, a, b] in CIELAB (D65); or give rgb or preset.',
            ),
            Spec(
                'rgb',
                (float,),
                'The reference color [r, g, b], sRGB, 0..255; or give lab or preset.',
            ),
            Spec('preset', '', 'A color that everybody knows by its name.', choices=('', *PRESETS)),
            Spec(
                'tolerance_lab',
                (float,),
                'Half axes [dL, da, db] of an ellipsoid in place of the sphere of tolerance.',
                unit='CIELAB units',
                minimum=0.0,
                maximum=200.0,
            ),
            Spec(
                'tolerance',
                _DEFAULT.colors[0].tolerance,
                'Pixels closer to the reference color belong to it (tau).',
                unit='CIELAB units',
                minimum=0.0,
                maximum=200.0,
            ),
        ],
        'regions': [
            Spec('polygon', (float,), 'Corners [u1, v1, u2, v2, ...].', unit='px'),
            Spec('ignore', False, 'Whether not to look in it; else to look nowhere outside.'),
        ],
    },
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
    colors = tuple(_color(name, values) for name in values['colors'])
    regions = tuple(_region(name, values) for name in values.get('regions', ()))
    own = own_values(DetectorConfig, values) | {'colors': colors, 'regions': regions}
    config = DetectorConfig(**own)
    Regions(config.regions, config.mask)  # reads the picture of the mask
    return DetectorSetup(config, **own_values(DetectorSetup, values))


def _region(name: str, values: Mapping[str, Any]) -> Region:
    corners = values.get(f'{name}.polygon', [])
    if len(corners) % 2:
        raise ValueError(f'{name}.polygon: expected pairs of u and v, got {len(corners)} numbers')
    pairs = tuple(zip(corners[::2], corners[1::2], strict=True))
    return Region(name, pairs, values[f'{name}.ignore'])


def _color(name: str, values: Mapping[str, Any]) -> ReferenceColor:
    given = {
        key: values[f'{name}.{key}']
        for key in ('lab', 'rgb', 'preset')
        if values.get(f'{name}.{key}')
    }
    if len(given) > 1:
        raise ValueError(f'{name}: expected one of lab, rgb and preset, got {" and ".join(given)}')
    tolerance, axes = values[f'{name}.tolerance'], values.get(f'{name}.tolerance_lab')
    axes = tuple(axes) if axes else None
    if 'lab' in given:
        return ReferenceColor(name, tuple(given['lab']), tolerance, axes)
    if 'rgb' in given:
        return ReferenceColor.from_rgb(name, given['rgb'], tolerance, axes)
    if 'preset' in given:
        color = ReferenceColor.from_preset(name, given['preset'])
        return replace(color, tolerance_lab=axes) if axes else color
    for color in _DEFAULT.colors:
        if color.name == name:
            return replace(color, tolerance=tolerance, tolerance_lab=axes)
    raise ValueError(f'{name}: expected {name}.lab, {name}.rgb or {name}.preset, got none of them')
