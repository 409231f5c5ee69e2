"""The parameters of the window tracker node."""

from collections.abc import Iterable
from collections.abc import Mapping
from dataclasses import dataclass
from dataclasses import fields
from typing import Any

from colortrack_ros.node_kit.image_tracker import IMAGE_TRACKER
from colortrack_ros.node_kit.image_tracker import ImageTrackerSetup
from colortrack_ros.node_kit.live_parameters import own_values
from colortrack_ros.node_kit.topics import topic
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import Spec
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows.config import METHODS
from colortrack_ros.windows.config import SUPERVISIONS
from colortrack_ros.windows.costs import COSTS

_DEFAULT = WindowConfig()


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
    return Spec(name, default, description, unit, minimum, maximum, tuple(choices))


TABLE = ParameterTable(
    [
        Spec(
            'targets',
            (float,),
            'Boxes in the first picture, u, v of the top left pixel, width, height, of one target '
            'after the other; set later, they start in the next picture.',
            unit='px',
            minimum=-1e5,
            maximum=1e5,
        ),
        _spec(
            'method',
            'Window matching alone, with the Kalman filter, or with the swarm besides.',
            choices=METHODS,
        ),
        _spec(
            'cost',
            'Cost function that compares the windows; sad, zsad and lsad are slow for large ones.',
            choices=COSTS,
        ),
        _spec('window', 'Side of the window (N), odd; 0: of each target its box.', 'px', 0, 999),
        _spec('search_width', 'Places that are compared, to the side, at least.', 'px', 3, 999),
        _spec('search_height', 'The same, up and down.', 'px', 3, 999),
        _spec(
            'ambiguity',
            'Places whose distance is greater than the least by no more than this share are '
            'candidates as well.',
            '',
            0.0,
            1.0,
        ),
        _spec(
            'drift_compensation',
            'Whether matches are validated, turns and changes of size told from motion, and '
            'templates kept as long as they will do; if not, every window is the next template.',
        ),
        _spec(
            'renewal',
            'A template is kept until its similarity has fallen by so much.',
            '',
            0.0,
            1.0,
        ),
        _spec('min_similarity', 'Least similarity of a valid match.', '', 0.0, 1.0),
        _spec(
            'max_drop',
            'A match is not valid when the similarity falls by more from one valid match to the '
            'next.',
            '',
            0.0,
            1.0,
        ),
        _spec(
            'max_deviation',
            'Greatest standard deviation of the place of a valid match.',
            'px',
            1e-3,
            1e3,
        ),
        _spec(
            'supervision',
            'Who is believed when match and filter disagree: a valid match, or whichever has moved '
            'less.',
            choices=SUPERVISIONS,
        ),
        _spec(
            'tolerance',
            'Match and filter disagree when u and v differ by more on average.',
            'px',
            0.0,
            1e4,
        ),
        _spec(
            'process_noise',
            'Standard deviation of the acceleration that the filter does not know (sigma_s).',
            'px/s^2',
            1e-3,
            1e6,
        ),
        _spec(
            'initial_speed',
            'Standard deviation of the velocity of a new target on each axis.',
            'px/s',
            1e-3,
            1e6,
        ),
        _spec('swarm_particles', 'Velocities that search for the best.', '', 1, 10_000),
        _spec('swarm_iterations', 'Steps that they take (K).', '', 1, 1000),
        _spec('swarm_own', 'Trust of a particle in its own best (c1).', '', 0.0, 4.0),
        _spec('swarm_common', 'Trust of a particle in the best of all (c2).', '', 0.0, 4.0),
        _spec('swarm_first_inertia', 'Weight of the inertia at first (W).', '', 0.0, 4.0),
        _spec('swarm_last_inertia', 'Weight of the inertia at last.', '', 0.0, 4.0),
        _spec('swarm_max_step', 'Longest step of a particle (V_max).', 'px/frame', 1e-3, 1e4),
        _spec('swarm_frames', 'Frames whose velocities count (T).', 'frames', 1, 100),
        _spec('swarm_random', 'Whether r1 and r2 are drawn; if not, they are 1.'),
        _spec('seed', 'Of the random numbers of the swarm.', '', 0, 2**31 - 1),
        _spec(
            'max_time_since_update',
            'A target without a valid match for longer is given up.',
            's',
            0.0,
            3600.0,
        ),
        _spec('max_targets', 'Further targets are refused.', '', 1, 10_000),
        _spec(
            'max_dt',
            'A longer jump of the stamps starts afresh, with the first targets.',
            's',
            1e-3,
            3600.0,
        ),
        topic('detections_topic', '', 'detections that start targets; empty: none'),
        *IMAGE_TRACKER,
    ]
)


@dataclass(frozen=True)
class WindowTrackerSetup(ImageTrackerSetup):
    """What every image tracker has, and:

    :param targets: (u, v, w, h) of each [px].
    """

    targets: tuple[tuple[float, ...], ...]
    detections_topic: str


def build(values: Mapping[str, Any]) -> WindowTrackerSetup:
    """The setup of a window tracker.

    :raises ValueError: the values do not fit together; the reason names the parameter.
    """
    config = WindowConfig(**{field.name: values[field.name] for field in fields(WindowConfig)})
    numbers = list(values.get('targets', ()))
    boxes = tuple(tuple(numbers[i : i + 4]) for i in range(0, len(numbers), 4))
    if any(len(box) != 4 or min(box[2:]) < 1 for box in boxes):
        raise ValueError(
            f'targets: expected u, v, width, height of each box, at least 1 px, got {numbers}'
        )
    own = own_values(WindowTrackerSetup, values) | {'targets': boxes}
    return WindowTrackerSetup(config, **own)
