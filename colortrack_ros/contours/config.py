"""Parameters of the contour tracker."""

from dataclasses import dataclass

from colortrack_ros.estimation.time_limits import TimeLimits
from colortrack_ros.parameters import DOCUMENT
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter

STARTS = ('background', 'difference', 'targets')
OUTLINES = ('area', 'box')
FILTERS = ('joint', 'two')


@dataclass(frozen=True)
class ContourConfig(TimeLimits):
    """Parameters of the contour tracker. Noises are variances per frame of 1 / rate."""

    start: str = parameter(
        'background',
        'What moving things differ from: the learned background, or the pictures start_interval '
        'and twice that before (frame differencing). targets: nothing is looked for, and what '
        'somebody names is followed by its edges alone, before a camera that moves as well.',
        choices=STARTS,
    )
    follow_foreground: bool = parameter(
        True,
        'Whether edges are believed where the foreground agrees alone, and elsewhere targets '
        'follow that; if not, as in the document, it starts targets and does no more.',
        audience=DOCUMENT,
    )
    outline: str = parameter(
        'area',
        "Where the first control points lie: on the area's outline, or as in the document on its "
        'box.',
        choices=OUTLINES,
        audience=DOCUMENT,
    )
    points: int = parameter(
        12, 'Control points and measurement lines of a contour (n).', limits=(6, 64)
    )
    interpolating: bool = parameter(
        True,
        'Whether the curve passes through the edges found; if not, as in the document, they are '
        'its control points.',
        audience=DOCUMENT,
    )
    line_length: int = parameter(
        30,
        'Length of a measurement line, half of it to each side of the contour.',
        unit='px',
        limits=(4, 200),
    )
    mask: tuple[float, ...] = parameter(
        [-1.2, -2.0, 0.0, 2.0, 1.2],
        'Weights of the edge detector along a line, odd in number, of sum 0.',
        audience=EXPERT,
    )
    sigma: float = parameter(
        3.0,
        'Standard deviation of an edge around the predicted point.',
        unit='px',
        limits=(0.1, 100.0),
        audience=EXPERT,
    )
    min_contrast: float = parameter(
        15.0, 'Weaker changes of intensity are no edges.', unit='levels', limits=(0.0, 255.0)
    )
    no_edge: float = parameter(
        2.0,
        'A line has no edge when the best is weaker: its contrast times a Gaussian that is 1 at '
        'the predicted point.',
        unit='levels',
        limits=(0.0, 255.0),
        audience=EXPERT,
    )
    inside_deviation: float = parameter(
        20.0,
        'Standard deviation of the intensity just inside an edge from what is usual on its line; '
        '0 accepts any.',
        unit='levels',
        limits=(0.0, 255.0),
        audience=EXPERT,
    )
    outside_deviation: float = parameter(
        40.0,
        'The same just outside the edge.',
        unit='levels',
        limits=(0.0, 255.0),
        audience=EXPERT,
    )
    outlier: float = parameter(
        4.0,
        'Gate of an edge around its prediction, or around the motion that most edges share; 0 '
        'takes all.',
        unit='standard deviations',
        limits=(0.0, 100.0),
        audience=EXPERT,
    )
    min_found: float = parameter(
        0.5,
        'A target with edges on a smaller share of its lines is not measured and coasts.',
        limits=(0.0, 1.0),
    )
    start_found: float = parameter(
        0.75, 'Share of its lines on which a new target needs edges.', limits=(0.0, 1.0)
    )
    rotation: bool = parameter(
        False, 'Whether rotation is estimated beside translation and scale.', audience=EXPERT
    )
    filters: str = parameter(
        'joint',
        'One filter of motion and shape, or as in the document one after the other, (7) and (8).',
        choices=FILTERS,
        audience=DOCUMENT,
    )
    edge_variance: float = parameter(
        0.1,
        'Variance of a measured edge (v).',
        unit='px^2',
        limits=(1e-4, 1e3),
        audience=EXPERT,
    )
    motion_noise: float = parameter(
        0.02,
        'Variance by which the velocity changes in a frame (q_u).',
        unit='px^2/frame^2',
        limits=(0.0, 1e3),
        audience=EXPERT,
    )
    scale_noise: float = parameter(
        1e-6,
        'Variance by which the rate of scaling changes in a frame (q_s).',
        unit='1/frame^2',
        limits=(0.0, 1.0),
        audience=EXPERT,
    )
    turn_noise: float = parameter(
        1e-5,
        'Variance by which the angular velocity changes in a frame.',
        unit='rad^2/frame^2',
        limits=(0.0, 1.0),
        audience=EXPERT,
    )
    shape_noise: float = parameter(
        0.005,
        'Variance by which each control point moves on its own in a frame (w).',
        unit='px^2',
        limits=(0.0, 1e3),
        audience=EXPERT,
    )
    rate: float = parameter(
        24.0,
        'Frame rate for which the noises are given; at others they are scaled.',
        unit='Hz',
        limits=(0.1, 1000.0),
        audience=EXPERT,
    )
    difference_threshold: float = parameter(
        20.0,
        'What differs from the background by more is a new target.',
        unit='levels',
        limits=(0.0, 254.0),
    )
    blur_sigma: float = parameter(
        1.5,
        'Standard deviation of the Gaussian before that threshold.',
        unit='px',
        limits=(0.0, 50.0),
    )
    min_area: int = parameter(
        150,
        'Smaller areas start no target (area opening).',
        unit='px',
        limits=(16, 1_000_000_000),
    )
    opening_size: int = parameter(
        3,
        'Side of the square of the opening that follows, odd.',
        unit='px',
        limits=(1, 99),
        audience=EXPERT,
    )
    learn_seconds: float = parameter(
        1.5,
        'Time during which what moves is taken out of a new background.',
        unit='s',
        limits=(0.0, 3600.0),
    )
    start_interval: float = parameter(
        0.5,
        'Time between the pictures that are compared for start difference.',
        unit='s',
        limits=(0.0, 3600.0),
    )
    min_motion: float = parameter(
        0.3,
        'A new target is confirmed when it has moved by so much of its size within 3 s: what '
        'only flickers, or was put there, does not; 0 confirms whatever differs.',
        limits=(0.0, 10.0),
    )
    min_score: float = parameter(
        0.5,
        'Confirmed targets less likely to exist than this are not published; they go on, and come '
        'back with their object.',
        limits=(0.0, 1.0),
    )
    max_targets: int = parameter(100, 'Targets that are followed at a time.', limits=(1, 500))

    def check(self) -> None:
        """Check that the opening has a center, and that the mask responds only to edges."""
        if self.opening_size % 2 == 0:
            raise ValueError(f'opening_size: expected an odd number of px, got {self.opening_size}')
        fits = 3 <= len(self.mask) <= 15 and len(self.mask) % 2 == 1
        if not fits or abs(sum(self.mask)) > 1e-6 or not any(self.mask):
            raise ValueError(
                'mask: expected 3 to 15 weights, odd in number, of sum 0 and not all 0, '
                f'got {list(self.mask)}'
            )
