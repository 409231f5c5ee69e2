"""The configuration of the window tracker: every field is a ROS parameter of the same name."""

from collections.abc import Iterable
from dataclasses import dataclass
import math

from colortrack_ros.windows.costs import COSTS

METHODS = ('WM', 'WM+K', 'WM+K+PSO')
SUPERVISIONS = ('confidence', 'discrepancy')


@dataclass(frozen=True)
class WindowConfig:
    """What a person may set.

    :param method: window matching alone, with the Kalman filter as its supervisor (4.3.1), and
        with the swarm besides (5.4.1).
    :param cost: a name in COSTS.
    :param window: N, side of the square window [px], odd; 0: each target's box.
    :param search_width, search_height: r and s, places that are compared, around the one expected
        [px]; more when the prediction's covariance says so.
    :param ambiguity: places whose distance exceeds the least by no more than this share of it are
        candidates as well.
    :param drift_compensation: the flag of 3.4.1: matches are validated, turns and changes of size
        are told from motion, and a template is kept as long as it will do; without it every window
        found is the next template.
    :param renewal: a template is kept until the similarity has fallen by so much.
    :param min_similarity: least similarity of a valid match, the zero-mean normalized correlation
        of window and template.
    :param max_drop: a match is not valid when the similarity is by more less than that of the last
        valid one: something covers the target.
    :param max_deviation: greatest standard deviation of the place of a valid match [px].
    :param supervision: who is believed when match and prediction disagree: `confidence`: a valid
        match; `discrepancy`: whichever has moved less since the last frame, as in 4.3.1.
    :param tolerance: they disagree when u and v differ by more on average [px].
    :param process_noise: sigma_s, standard deviation of the acceleration [px/s^2].
    :param initial_speed: standard deviation of the first velocity on each axis [px/s].
    :param swarm_particles: number of velocities that search for the best.
    :param swarm_iterations: K of (5.3).
    :param swarm_own, swarm_common: c_1 and c_2 of (5.2), trust in the best place that a particle
        and the swarm have found.
    :param swarm_first_inertia, swarm_last_inertia: W of (5.2) in the first and last iteration.
    :param swarm_max_step: V_max of (5.4), of a particle in an iteration [px/frame].
    :param swarm_frames: T of (5.5).
    :param swarm_random: draw r_1 and r_2; without it they are 1.
    :param seed: of the swarm.
    :param max_time_since_update: a target without a valid match for longer is given up [s].
    :param max_targets: so many are followed at a time; further ones are refused.
    :param max_dt: a longer jump of the stamps starts the tracker afresh [s].
    :raises ValueError: when a value is out of its range; the message says which and why.
    """

    method: str = 'WM+K+PSO'
    cost: str = 'ssd'
    window: int = 0
    search_width: int = 40
    search_height: int = 40
    ambiguity: float = 0.1
    drift_compensation: bool = True
    renewal: float = 0.03
    min_similarity: float = 0.8
    max_drop: float = 0.02
    max_deviation: float = 1.0
    supervision: str = 'confidence'
    tolerance: float = 3.0
    process_noise: float = 500.0
    initial_speed: float = 300.0
    swarm_particles: int = 100
    swarm_iterations: int = 10
    swarm_own: float = 2.0
    swarm_common: float = 2.0
    swarm_first_inertia: float = 0.9
    swarm_last_inertia: float = 0.1
    swarm_max_step: float = 100.0
    swarm_frames: int = 3
    swarm_random: bool = True
    seed: int = 0
    max_time_since_update: float = 1.5
    max_targets: int = 100
    max_dt: float = 2.0

    def __post_init__(self) -> None:
        self._named('method', METHODS)
        self._named('cost', COSTS)
        self._named('supervision', SUPERVISIONS)
        self._ranged('window', 0, 999, 'px')
        if self.window and self.window % 2 == 0:
            raise ValueError(f'window is {self.window}, expected an odd number of px, or 0')
        for name in ('search_width', 'search_height'):
            self._ranged(name, 3, 999, 'px')
        for name in ('ambiguity', 'renewal', 'min_similarity', 'max_drop'):
            self._ranged(name, 0.0, 1.0)
        self._ranged('max_deviation', 1e-3, 1e3, 'px')
        self._ranged('tolerance', 0.0, 1e4, 'px')
        self._ranged('process_noise', 1e-3, 1e6, 'px/s^2')
        self._ranged('initial_speed', 1e-3, 1e6, 'px/s')
        self._ranged('swarm_particles', 1, 10_000)
        self._ranged('swarm_iterations', 1, 1000)
        for name in ('swarm_own', 'swarm_common', 'swarm_first_inertia', 'swarm_last_inertia'):
            self._ranged(name, 0.0, 4.0)
        self._ranged('swarm_max_step', 1e-3, 1e4, 'px/frame')
        self._ranged('swarm_frames', 1, 100, 'frames')
        self._ranged('seed', 0, 2**31 - 1)
        self._ranged('max_time_since_update', 0.0, 3600.0, 's')
        self._ranged('max_targets', 1, 10_000)
        self._ranged('max_dt', 1e-3, 3600.0, 's')

    def _named(self, name: str, known: Iterable[str]) -> None:
        value = getattr(self, name)
        if value not in known:
            raise ValueError(f'{name} is {value!r}, expected one of {", ".join(known)}')

    def _ranged(self, name: str, low: float, high: float, unit: str = '') -> None:
        value = getattr(self, name)
        if not (math.isfinite(value) and low <= value <= high):
            raise ValueError(f'{name} is {value!r}, expected {low:g} to {high:g} {unit}'.rstrip())
