"""Parameters of the tracker."""

from dataclasses import dataclass
from dataclasses import replace

from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.estimation.time_limits import MOST_SECONDS
from colortrack_ros.estimation.time_limits import TimeLimits
from colortrack_ros.parameters import DOCUMENT
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter
from colortrack_ros.tracking.association import ASSOCIATORS


@dataclass(frozen=True)
class TrackerConfig(TimeLimits):
    """How detections become tracks."""

    max_hidden: float = parameter(
        6.0,
        'A deleted track is remembered until it has not been measured for longer: if its object '
        'comes back, by color, size, place and motion, its ID does. If it left the picture, for '
        'max_time_since_update. That or less: none is remembered. Where four frames take longer '
        'than max_time_since_update, it is longer in proportion.',
        unit='s',
        limits=(0.0, 3600.0),
    )
    population: tuple[int, ...] = parameter(
        [0],
        "Number of objects of each color, in the order of the detector's colors; 0, or none: not "
        'known. Where it is known their IDs are 1 to n for good, those of the next color go on '
        'from there: what appears when all have been seen is the likeliest of those out of sight, '
        'however long they were. A track has its ID, and is published, once it is confirmed. After '
        'a reset they are given anew.',
        limits=(0, 10_000),
    )
    min_score: float = parameter(
        0.5,
        'Confirmed tracks less likely to exist than this are not published; they go on, and come '
        'back with their object.',
        limits=(0.0, 1.0),
    )
    process_noise: float = parameter(
        0.0,
        'Standard deviation of the acceleration that the motion model does not know (sigma_s), of '
        'density q = sigma_s^2 / 30: what one drawn anew 30 times a second does to the velocity, '
        'whatever the frame rate. 0 learns it from the innovations.',
        unit='px/s^2',
        limits=(0.0, 1e6),
    )
    acceleration: tuple[float, float] = parameter(
        (0.0, 0.0),
        'Known in advance, along u and v, such as gravity; for the motion models '
        'known_acceleration and switched_pair.',
        unit='px/s^2',
        limits=(-1e6, 1e6),
        audience=EXPERT,
    )
    acceleration_span: float = parameter(
        0.0,
        'Of motion models known_acceleration and switched_pair: the acceleration of a track is '
        'the second difference of its past positions, measured at least so far apart, and stays '
        'while it is hidden. Its error is in no covariance: 2.4 measurement_noise / span^2. '
        '0: acceleration holds for all.',
        unit='s',
        limits=(0.0, 10.0),
        audience=DOCUMENT,
    )
    trust: tuple[float, float] = parameter(
        (10.0, 0.1),
        'Of motion model switched_pair: how many times larger than it is its two filters take the '
        'process noise to be. The first, of what is measured, trusts the measurement for more '
        'than 1, the second, of what is hidden, the model for less.',
        limits=(1e-6, 1e6),
        audience=DOCUMENT,
    )
    maneuvers: bool = parameter(
        True, 'Whether objects may turn or bounce; how often is learned.', audience=EXPERT
    )
    measurement_noise: float = parameter(
        1.0,
        'Standard deviation of a measured position, where a detection brings no covariance: '
        'a guess, held to be 2.1 times as large until the detections show it.',
        unit='px',
        limits=(1e-3, 1e3),
    )
    detection_covariance: bool = parameter(
        True,
        'Whether the covariance that a detection brings is used, and a factor on it, or on '
        'measurement_noise, is learned from how the detections scatter; if not, measurement_noise '
        'holds for all.',
        audience=EXPERT,
    )
    centroid_bias: float = parameter(
        0.06,
        'Standard deviation of what is systematic about centroids, on each axis, which no filter '
        'averages out; adds to the published covariance.',
        unit='px',
        limits=(0.0, 1e3),
        audience=EXPERT,
    )
    color_gating: bool = parameter(
        True,
        'Whether a track takes only detections of its own color. Off for detectors whose labels '
        'flip, such as networks that call a car a truck: else each label has a track of its own.',
    )
    use_boxes: bool = parameter(
        True, 'Whether the bounding boxes tell when an object is cut or merged with another.'
    )
    ego_motion: str = parameter(
        'auto',
        "How the camera's own motion is known: none, it stands; detections, by what the motions of "
        'most objects, at least five, have in common; auto, so while it is evident, else it '
        'stands; odometry, by where the robot and the camera on it are (pose_source): what leaves '
        'the picture by that is remembered (max_hidden).',
        choices=('none', 'auto', 'detections', 'odometry'),
    )
    max_detections: int = parameter(
        10_000,
        'Detections of a frame that are worked on; of more the largest, and the others are '
        'counted. As many take a second on a slow machine.',
        limits=(1, 1_000_000),
        audience=EXPERT,
    )
    motion_model: str = parameter(
        'constant_velocity',
        'How objects move between frames. For objects in flight and in hands by turns, '
        'constant_velocity: there constant_acceleration and imm lose them at each turn.',
        choices=MOTION_MODELS,
        audience=EXPERT,
    )
    associator: str = parameter(
        'gnn',
        'How detections are given to tracks. jpda is for points in clutter; where objects bounce '
        'or merge, gnn keeps more identities.',
        choices=ASSOCIATORS,
        audience=EXPERT,
    )
    initial_speed: float = parameter(
        0.0,
        'Standard deviation of the velocity of a new track, and of what a maneuver changes, on '
        'each axis. 0 learns it from the tracks.',
        unit='px/s',
        limits=(0.0, 1e6),
        audience=EXPERT,
    )
    detection_probability: float = parameter(
        0.95,
        'That a visible object is detected in a frame, to begin with; less is learned.',
        limits=(0.01, 0.999),
        audience=EXPERT,
    )
    clutter_density: float = parameter(
        0.0,
        'Detections a frame that belong to no track yet, false or new; sets the gate and the cost '
        'of a miss. 0 learns it.',
        unit='1/px^2',
        limits=(0.0, 1.0),
        audience=EXPERT,
    )
    gating: bool = parameter(
        True,
        'Whether detections that are unlikely to be of a track are refused; if not, any may be of '
        'any, and none is left over while a track is.',
        audience=DOCUMENT,
    )
    confirm_hits: int = parameter(
        3,
        'A track with this many detections in its first confirm_window frames is confirmed.',
        limits=(1, 100),
    )
    confirm_window: int = parameter(
        4,
        'First frames in which a track needs confirm_hits detections; one that cannot is deleted.',
        unit='frames',
        limits=(1, 100),
    )
    start_score: float = parameter(
        0.4,
        'Of boxes of a network: those with a lower score, as a share of the best of late, go on '
        'with objects that are known, and start none. 0: any may.',
        limits=(0.0, 1.0),
    )
    max_position_sigma: float = parameter(
        300.0,
        'A track whose position is known less well is deleted.',
        unit='px',
        limits=(1e-3, 1e9),
        audience=EXPERT,
    )
    image_size: tuple[int, int] = parameter(
        (0, 0),
        'Width and height of the picture; a track that has left it is deleted. 0: what the '
        "pictures, or the camera's CameraInfo, say.",
        unit='px',
        limits=(0, 100_000),
    )

    def check(self) -> None:
        """confirm_hits within confirm_window."""
        if self.confirm_hits > self.confirm_window:
            raise ValueError(
                f'confirm_window: expected at least confirm_hits, {self.confirm_hits}, '
                f'got {self.confirm_window}'
            )

    def outliving(self, least: float) -> 'TrackerConfig':
        """The same, with which tracks outlive at least so long without a measurement [s].

        If deleted ones are remembered, they are so longer in proportion.
        """
        given, hidden = self.max_time_since_update, self.max_hidden
        if 0 < given < min(least, hidden):
            hidden = min(hidden * least / given, MOST_SECONDS)
        lives, waits = max(given, least), max(self.max_dt, least)
        return replace(self, max_time_since_update=lives, max_dt=waits, max_hidden=hidden)
