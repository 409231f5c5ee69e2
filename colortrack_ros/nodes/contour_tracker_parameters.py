"""The parameters of the contour tracker node."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours.config import CHOICES
from colortrack_ros.contours.config import RANGES
from colortrack_ros.node_kit.image_tracker import IMAGE_TRACKER
from colortrack_ros.node_kit.image_tracker import ImageTrackerSetup
from colortrack_ros.node_kit.live_parameters import own_values
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import Spec

_DEFAULT = ContourConfig()


def _spec(name: str, description: str, unit: str = '') -> Spec:
    """A row with the default, the range and the choices of the room."""
    default = getattr(_DEFAULT, name)
    low, high = RANGES.get(name, (None, None))
    value = list(default) if isinstance(default, tuple) else default
    return Spec(name, value, description, unit, low, high, tuple(CHOICES.get(name, ())))


TABLE = ParameterTable(
    [
        _spec(
            'start',
            'What new targets are told from: the learned background, or the picture start_interval '
            'before.',
        ),
        _spec(
            'outline',
            "Where the first control points are: along the area's outline, or along its box.",
        ),
        _spec('points', 'Control points and measurement lines of a contour (n).'),
        _spec(
            'interpolating',
            'Whether lines stand on the curve; if not, the edges found are its control points.',
        ),
        _spec('line_length', 'Length of a measurement line, half to each side (L).', 'px'),
        _spec('mask', 'Weights of the edge detector along a line, odd in number, of sum 0.'),
        _spec(
            'sigma',
            'Standard deviation of an edge around the point predicted.',
            'px',
        ),
        _spec('min_contrast', 'Weaker changes of intensity are no edges.', 'levels'),
        _spec(
            'no_edge',
            'A line has no edge when the best is weaker: its contrast times the Gaussian, which is '
            '1 at the point predicted.',
            'levels',
        ),
        _spec(
            'inside_deviation',
            'Standard deviation of the intensity just inside of an edge from what is usual on its '
            'line; 0: any will do.',
            'levels',
        ),
        _spec('outside_deviation', 'The same just outside of it.', 'levels'),
        _spec(
            'outlier',
            'An edge farther from where it is expected, and from where the motion of the whole '
            'contour puts it, is none; 0: all are taken.',
            'standard deviations',
        ),
        _spec(
            'min_found',
            'A target with edges on a smaller part of its lines is not measured and coasts.',
        ),
        _spec('start_found', 'A new target needs edges on such a part of its lines.'),
        _spec('rotation', 'Whether rotation is estimated beside translation and scale.'),
        _spec(
            'filters',
            'One filter of motion and shape, or as in the document two in turn, (7) and (8).',
        ),
        _spec('edge_variance', 'Variance of an edge found (v).', 'px^2'),
        _spec('motion_noise', 'Variance by which the velocity changes (q_u).', 'px^2/frame^2'),
        _spec('scale_noise', 'Variance by which the change of scale changes (q_s).', '1/frame^2'),
        _spec('turn_noise', 'Variance by which the angular velocity changes.', 'rad^2/frame^2'),
        _spec('shape_noise', 'Variance by which each control point changes (w).', 'px^2'),
        _spec(
            'rate', 'Of the frames that the noises are for; at other rates they are scaled.', 'Hz'
        ),
        _spec('difference_threshold', 'What differs by more is a new target.', 'levels'),
        _spec('blur_sigma', 'Of the Gaussian before that threshold.', 'px'),
        _spec('min_area', 'Smaller areas start no target (area opening).', 'px'),
        _spec('opening_size', 'Side of the square of the opening that follows, odd.', 'px'),
        _spec('learn_seconds', 'How long what moves is taken out of a new background.', 's'),
        _spec('start_interval', 'Time between two looks for new targets.', 's'),
        _spec('max_time_since_update', 'A target unmeasured for longer is given up.', 's'),
        _spec('max_targets', 'So many are followed at a time.'),
        _spec('max_dt', 'A longer jump of the stamps starts afresh.', 's'),
        *IMAGE_TRACKER,
    ]
)


def build(values: Mapping[str, Any]) -> ImageTrackerSetup:
    """The setup of a contour tracker.

    :raises ValueError: the values do not fit together; the reason names the parameter.
    """
    room = {field.name: values[field.name] for field in fields(ContourConfig)}
    config = ContourConfig(**room | {'mask': tuple(values['mask'])})
    return ImageTrackerSetup(config, **own_values(ImageTrackerSetup, values))
