"""Parameters of the window tracker."""

from dataclasses import dataclass

from colortrack_ros.estimation.box_centers import LASTING_SHARE
from colortrack_ros.estimation.time_limits import TimeLimits
from colortrack_ros.parameters import DOCUMENT
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter
from colortrack_ros.windows.costs import COSTS

WINDOW_METHODS = ('WM', 'WM+K', 'WM+K+PSO')
SUPERVISIONS = ('confidence', 'discrepancy')

LEAST_SIDE = 5
"""Least width and height of a template [px]: 25 pixels for the six unknowns of Template.align."""


@dataclass(frozen=True)
class WindowConfig(TimeLimits):
    """How windows of a picture are tracked."""

    method: str = parameter(
        'WM+K',
        'Window matching alone, with a Kalman filter as its supervisor (4.3.1), or with the swarm '
        'as well (5.4.1), which finds little more than the mean of the last velocities.',
        choices=WINDOW_METHODS,
    )
    cost: str = parameter(
        'ssd',
        'Cost function that compares windows; sad, zsad and lsad are slow for large ones.',
        choices=COSTS,
        audience=EXPERT,
    )
    window: int = parameter(
        0,
        "Side of the square window, odd, from 5 on; 0 takes each target's box.",
        unit='px',
        limits=(0, 999),
    )
    search_width: int = parameter(
        40,
        'Width of the search region around the predicted position, at least; it grows with the '
        "prediction's covariance (r).",
        unit='px',
        limits=(3, 999),
    )
    search_height: int = parameter(
        40, 'Height of the search region, at least (s).', unit='px', limits=(3, 999)
    )
    ambiguity: float = parameter(
        0.1,
        'Positions whose distance exceeds the least by at most this share of it are candidates as '
        'well.',
        limits=(0.0, 1.0),
        audience=EXPERT,
    )
    drift_compensation: bool = parameter(
        True,
        'Whether matches are validated, rotation and scale are told from translation, and a '
        'template is kept as long as it serves (3.4.1); if not, every window found is the next '
        'template.',
    )
    appearance: bool = parameter(
        True,
        'Whether a target whose template is not found is looked for by a correlation filter and by '
        'its colors, which learn what it and what is around it look like, and whether its box '
        'changes its size with it; with drift_compensation.',
    )
    renewal: float = parameter(
        0.03,
        'A template is kept until its similarity has fallen by this much.',
        limits=(0.0, 1.0),
        audience=EXPERT,
    )
    min_similarity: float = parameter(
        0.8,
        'Least similarity of a valid match, 1 for a window that is the template.',
        limits=(0.0, 1.0),
    )
    max_drop: float = parameter(
        0.02,
        'A match is invalid when its similarity, less what noise explains, is below that of the '
        'last valid one by more: something covers the target.',
        limits=(0.0, 1.0),
        audience=EXPERT,
    )
    max_deviation: float = parameter(
        1.0,
        'Greatest standard deviation of the position of a valid match.',
        unit='px',
        limits=(1e-3, 1e3),
        audience=EXPERT,
    )
    box_error: float = parameter(
        LASTING_SHARE,
        "How far the middle of a first box is off its target's, as a standard deviation over the "
        'longer side: part of the covariance where the template is found. 0 for exact boxes.',
        limits=(0.0, 1.0),
        audience=EXPERT,
    )
    supervision: str = parameter(
        'confidence',
        'Who is believed when match and prediction disagree: a valid match, or, as in 4.3.1, '
        'whichever has moved less since the last frame.',
        choices=SUPERVISIONS,
        audience=DOCUMENT,
    )
    tolerance: float = parameter(
        3.0,
        'Match and prediction disagree when u and v differ by more on average.',
        unit='px',
        limits=(0.0, 1e4),
        audience=EXPERT,
    )
    process_noise: float = parameter(
        500.0,
        'Standard deviation of the acceleration that the filter does not know (sigma_s), of '
        'density q = sigma_s^2 / 30, whatever the frame rate.',
        unit='px/s^2',
        limits=(1e-3, 1e6),
    )
    initial_speed: float = parameter(
        300.0,
        'Standard deviation of the velocity of a new target on each axis.',
        unit='px/s',
        limits=(1e-3, 1e6),
        audience=EXPERT,
    )
    swarm_particles: int = parameter(
        100,
        'Particles of the swarm, each a velocity.',
        limits=(1, 10_000),
        audience=DOCUMENT,
    )
    swarm_iterations: int = parameter(
        10, 'Iterations of the swarm (K).', limits=(1, 1000), audience=DOCUMENT
    )
    swarm_own: float = parameter(
        2.0,
        'Trust of a particle in its own best velocity (c1).',
        limits=(0.0, 4.0),
        audience=DOCUMENT,
    )
    swarm_common: float = parameter(
        2.0,
        'Trust of a particle in the best velocity of all (c2).',
        limits=(0.0, 4.0),
        audience=DOCUMENT,
    )
    swarm_first_inertia: float = parameter(
        0.9,
        'Inertia of a particle in the first iteration (W).',
        limits=(0.0, 4.0),
        audience=DOCUMENT,
    )
    swarm_last_inertia: float = parameter(
        0.1,
        'Inertia of a particle in the last iteration.',
        limits=(0.0, 4.0),
        audience=DOCUMENT,
    )
    swarm_max_step: float = parameter(
        100.0,
        'Longest step of a particle in an iteration (V_max).',
        unit='px/frame',
        limits=(1e-3, 1e4),
        audience=DOCUMENT,
    )
    swarm_frames: int = parameter(
        3,
        'Frames whose velocities count (T).',
        unit='frames',
        limits=(1, 100),
        audience=DOCUMENT,
    )
    swarm_random: bool = parameter(
        True, 'Whether r1 and r2 are random; if not, they are 1.', audience=DOCUMENT
    )
    seed: int = parameter(
        0,
        'Seed of the random numbers of the swarm.',
        limits=(0, 2**31 - 1),
        audience=DOCUMENT,
    )
    max_targets: int = parameter(
        100, 'Targets that are followed at a time; more are refused.', limits=(1, 10_000)
    )

    def check(self) -> None:
        """A window with a pixel in its middle."""
        if self.window and (self.window % 2 == 0 or self.window < LEAST_SIDE):
            raise ValueError(
                f'window: expected an odd number of at least {LEAST_SIDE} px, or 0, '
                f'got {self.window}'
            )
