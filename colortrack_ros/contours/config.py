"""The configuration of the contour tracker: every field is a ROS parameter of the same name."""

from dataclasses import dataclass
import math

STARTS = ('background', 'difference')
OUTLINES = ('area', 'box')
FILTERS = ('joint', 'two')

RANGES: dict[str, tuple[float, float]] = {
    'points': (6, 64),
    'line_length': (4, 200),
    'sigma': (0.1, 100.0),
    'min_contrast': (0.0, 255.0),
    'no_edge': (0.0, 255.0),
    'inside_deviation': (0.0, 255.0),
    'outside_deviation': (0.0, 255.0),
    'outlier': (0.0, 100.0),
    'min_found': (0.0, 1.0),
    'start_found': (0.0, 1.0),
    'edge_variance': (1e-4, 1e3),
    'motion_noise': (0.0, 1e3),
    'scale_noise': (0.0, 1.0),
    'turn_noise': (0.0, 1.0),
    'shape_noise': (0.0, 1e3),
    'rate': (0.1, 1000.0),
    'difference_threshold': (0.0, 254.0),
    'blur_sigma': (0.0, 50.0),
    'min_area': (16, 1_000_000_000),
    'opening_size': (1, 99),
    'learn_seconds': (0.0, 3600.0),
    'start_interval': (0.0, 3600.0),
    'max_time_since_update': (0.0, 3600.0),
    'max_targets': (1, 500),
    'max_dt': (1e-3, 3600.0),
}
CHOICES = {'start': STARTS, 'outline': OUTLINES, 'filters': FILTERS}


@dataclass(frozen=True)
class ContourConfig:
    """What a person may set. Noises are variances that grow in a frame of 1 / rate.

    :param start: what targets are told from: the learned background, or the picture of the look
        before, start_interval ago (frame differencing).
    :param outline: where the first control points are: along the area's outline, or as in the
        document along its box.
    :param points: n, control points and measurement lines of a contour.
    :param interpolating: lines stand on the curve; if not, as in the document, the edges found are
        taken for its control points.
    :param line_length: L [px], half of it to each side.
    :param mask: of the edge detector along a line, odd in number.
    :param sigma: standard deviation of an edge around the point predicted [px].
    :param min_contrast: weaker changes of intensity are no edges [levels].
    :param no_edge: a line has no edge when the best is weaker, its contrast times the Gaussian,
        1 at the point predicted [levels].
    :param inside_deviation: standard deviation of the intensity just inside of an edge from that
        usual on its line [levels]; 0: any will do.
    :param outside_deviation: the same just outside.
    :param outlier: an edge farther from where it is expected, and from where the motion of most
        puts it, is none [standard deviations]; 0: all are taken.
    :param min_found: a target with edges on a smaller part of its lines is not measured.
    :param start_found: a new target needs edges on such a part of its lines.
    :param rotation: estimate rotation beside translation and scale.
    :param filters: one filter for motion and shape, or as in the document two in turn.
    :param edge_variance: v, of an edge found [px^2].
    :param motion_noise: q_u, of the velocity [px^2/frame^2].
    :param scale_noise: q_s, of the change of scale [1/frame^2].
    :param turn_noise: of the angular velocity [rad^2/frame^2].
    :param shape_noise: w, of each control point [px^2].
    :param rate: of the frames that the noises are for [Hz]; at others they are scaled.
    :param difference_threshold: what differs by more is a target [levels].
    :param blur_sigma: of the Gaussian before the threshold [px].
    :param min_area: smaller components are dropped (area opening) [px].
    :param opening_size: side of the square of the opening [px], odd.
    :param learn_seconds: how long what moves is taken out of a new background [s].
    :param start_interval: time between two looks for new targets [s].
    :param max_time_since_update: a target unmeasured for longer is given up [s].
    :param max_targets: so many are followed at a time.
    :param max_dt: a longer jump of the stamps starts the tracker afresh [s].
    :raises ValueError: when a value is out of its range; the message says which and why.
    """

    start: str = 'background'
    outline: str = 'area'
    points: int = 12
    interpolating: bool = True
    line_length: int = 30
    mask: tuple[float, ...] = (-1.2, -2.0, 0.0, 2.0, 1.2)
    sigma: float = 3.0
    min_contrast: float = 15.0
    no_edge: float = 2.0
    inside_deviation: float = 20.0
    outside_deviation: float = 40.0
    outlier: float = 4.0
    min_found: float = 0.5
    start_found: float = 0.75
    rotation: bool = False
    filters: str = 'joint'
    edge_variance: float = 0.1
    motion_noise: float = 0.02
    scale_noise: float = 1e-6
    turn_noise: float = 1e-5
    shape_noise: float = 0.005
    rate: float = 24.0
    difference_threshold: float = 20.0
    blur_sigma: float = 1.5
    min_area: int = 150
    opening_size: int = 3
    learn_seconds: float = 1.0
    start_interval: float = 0.5
    max_time_since_update: float = 1.5
    max_targets: int = 100
    max_dt: float = 2.0

    def __post_init__(self) -> None:
        for name, choices in CHOICES.items():
            value = getattr(self, name)
            if value not in choices:
                raise ValueError(f'{name} is {value!r}, expected one of {", ".join(choices)}')
        for name, (low, high) in RANGES.items():
            value = getattr(self, name)
            if not (math.isfinite(value) and low <= value <= high):
                raise ValueError(f'{name} is {value!r}, expected {low:g} to {high:g}')
        if self.opening_size % 2 == 0:
            raise ValueError(f'opening_size is {self.opening_size}, expected an odd number of px')
        if not 3 <= len(self.mask) <= 15 or len(self.mask) % 2 == 0 or abs(sum(self.mask)) > 1e-6:
            raise ValueError(
                f'mask is {list(self.mask)}, expected 3 to 15 weights, odd in number, of sum 0'
            )
        if not sum(map(abs, self.mask)) > 0:
            raise ValueError(f'mask is {list(self.mask)}, expected weights that are not all 0')
