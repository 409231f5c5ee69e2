"""The configuration of the tracker: every field is a ROS parameter of the same name."""

from collections.abc import Mapping
from dataclasses import dataclass
import math

from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.tracking.association import ASSOCIATORS


@dataclass(frozen=True)
class TrackerConfig:
    """What a person may set.

    :param motion_model: a name in MOTION_MODELS.
    :param associator: a name in ASSOCIATORS.
    :param process_noise: sigma_s, standard deviation of the acceleration [px/s^2], (2.23); 0:
        learned from the innovations.
    :param acceleration: known in advance, (u, v) [px/s^2]; of the models known_acceleration and
        switched_pair.
    :param maneuvers: objects may turn or bounce; how often is learned.
    :param measurement_noise: sigma_w [px], (2.30); where a detection's covariance is all zero.
    :param detection_covariance: use the covariance that a detection brings; without it,
        measurement_noise holds for all.
    :param centroid_bias: standard deviation of what is systematic about centroids, on each axis:
        shading, blur and the threshold shift a blob's outline in every frame alike, which no filter
        averages out [px]. It adds to the covariance that is published.
    :param use_boxes: learn each object's size and see from the boxes when it is cut or merged.
    :param color_gating: a detection of another color cannot be assigned to a track.
    :param initial_speed: standard deviation of the first velocity, and of what a maneuver changes,
        on each axis [px/s]; 0: learned from the tracks.
    :param detection_probability: that a visible object is detected in a frame.
    :param clutter_density: detections a frame that belong to no track yet, false or new
        [1/px^2]; it sets gate and cost of a miss. 0: learned.
    :param gating: without it every detection may be any track's, and none is missed while a pair
        is left.
    :param confirm_hits: detections that confirm a track, among
    :param confirm_window: its first so many frames.
    :param max_time_since_update: a track unmeasured for longer is deleted [s].
    :param max_position_sigma: a track whose position is known less well, on the axis where it is
        known least, is deleted [px].
    :param image_size: width and height of the picture [px]; a track that has left it is deleted.
        (0, 0): not known.
    :param max_dt: a longer jump of the stamps starts the tracker afresh [s].
    :raises ValueError: when a value is out of its range; the message says which and why.
    """

    motion_model: str = 'constant_velocity'
    associator: str = 'gnn'
    process_noise: float = 0.0
    acceleration: tuple[float, float] = (0.0, 0.0)
    maneuvers: bool = True
    measurement_noise: float = 1.0
    detection_covariance: bool = True
    centroid_bias: float = 0.06
    use_boxes: bool = True
    color_gating: bool = True
    initial_speed: float = 0.0
    detection_probability: float = 0.95
    clutter_density: float = 0.0
    gating: bool = True
    confirm_hits: int = 3
    confirm_window: int = 4
    max_time_since_update: float = 1.5
    max_position_sigma: float = 300.0
    image_size: tuple[int, int] = (0, 0)
    max_dt: float = 2.0

    def __post_init__(self) -> None:
        self._named('motion_model', MOTION_MODELS)
        self._named('associator', ASSOCIATORS)
        self._ranged('process_noise', 0.0, 1e6, 'px/s^2')
        self._ranged('measurement_noise', 1e-3, 1e3, 'px')
        self._ranged('centroid_bias', 0.0, 1e3, 'px')
        self._ranged('initial_speed', 0.0, 1e6, 'px/s')
        self._ranged('detection_probability', 0.01, 0.999)
        self._ranged('clutter_density', 0.0, 1.0, '1/px^2')
        self._ranged('confirm_hits', 1, 100)
        self._ranged('confirm_window', self.confirm_hits, 100)
        self._ranged('max_time_since_update', 0.0, 3600.0, 's')
        self._ranged('max_position_sigma', 1e-3, 1e9, 'px')
        self._ranged('max_dt', 1e-3, 3600.0, 's')
        self._paired('acceleration', -1e6, 1e6, 'px/s^2')
        self._paired('image_size', 0, 100_000, 'px')

    def _named(self, name: str, known: Mapping[str, object]) -> None:
        value = getattr(self, name)
        if value not in known:
            raise ValueError(f'{name} is {value!r}, expected one of {", ".join(sorted(known))}')

    def _paired(self, name: str, low: float, high: float, unit: str) -> None:
        value = tuple(getattr(self, name))
        object.__setattr__(self, name, value)
        if len(value) != 2 or not all(math.isfinite(x) and low <= x <= high for x in value):
            raise ValueError(f'{name} is {value!r}, expected two of {low:g} to {high:g} {unit}')

    def _ranged(self, name: str, low: float, high: float, unit: str = '') -> None:
        value = getattr(self, name)
        if not (math.isfinite(value) and low <= value <= high):
            raise ValueError(f'{name} is {value!r}, expected {low:g} to {high:g} {unit}'.rstrip())
