"""Parameters of the room, its things, the robot, and its camera."""

from dataclasses import dataclass

from colortrack_ros.parameters import Config
from colortrack_ros.parameters import named
from colortrack_ros.parameters import parameter
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.poses import require_radians

SHAPES = ('ball', 'cylinder')
ROOM_NAMES = ('balls', 'empty')


@dataclass(frozen=True)
class ThingConfig(Config):
    """Parameters of one thing in the room: NAME.shape and so on."""

    shape: str = parameter('ball', 'A ball, or a cylinder that stands.', choices=SHAPES)
    rgb: tuple[float, ...] = parameter(
        (205.0, 58.0, 34.0), 'Color, red, green, blue.', limits=(0.0, 255.0)
    )
    diameter: float = parameter(0.2, 'Diameter of the thing.', unit='m', limits=(0.01, 10.0))
    height: float = parameter(
        0.4, 'Height of a cylinder; a ball has none.', unit='m', limits=(0.01, 10.0)
    )
    path: tuple[float, ...] = parameter(
        [2.0, 0.0],
        'Corners of the closed path that it goes: x, y, x, y, ...; one corner: it stands.',
        unit='m',
        limits=(-100.0, 100.0),
    )
    speed: float = parameter(0.4, 'Speed along the path.', unit='m/s', limits=(0.0, 100.0))
    bounce_height: float = parameter(
        0.0,
        'Height up to which it is kicked whenever it has bounced out; 0: it rolls.',
        unit='m',
        limits=(0.0, 10.0),
    )
    restitution: float = parameter(
        0.7, 'Share of the speed that is left after a bounce.', limits=(0.0, 0.95)
    )

    def check(self) -> None:
        """Check that corners come in pairs."""
        if len(self.path) < 2 or len(self.path) % 2:
            raise ValueError(
                f'path: expected x and y of each corner, at least one, got {list(self.path)}'
            )


@dataclass(frozen=True)
class Thing:
    """One thing in the room.

    :param name: its name in parameters.
    :param config: its parameters.
    """

    name: str
    config: ThingConfig


@dataclass(frozen=True)
class SimulationConfig(Config):
    """Parameters of the room, the robot, and its camera."""

    room: str = parameter(
        'balls',
        'What is there besides objects: balls that stand, roll, bounce, and hide behind pillars; '
        'or nothing.',
        choices=ROOM_NAMES,
        read_only=True,
    )
    objects: tuple[Thing, ...] = named((), 'Names of further things.', ThingConfig, Thing)
    rate: float = parameter(
        30.0,
        'Pictures in a second of simulated time.',
        unit='Hz',
        limits=(1.0, 200.0),
        read_only=True,
    )
    picture_size: tuple[int, ...] = parameter(
        (640, 480),
        'Width and height of the pictures.',
        unit='px',
        limits=(16, 4096),
        read_only=True,
    )
    focal_length: float = parameter(
        520.0, 'Focal length of the camera.', unit='px', limits=(1.0, 1e5), read_only=True
    )
    distortion: tuple[float, ...] = parameter(
        (-0.28, 0.09, 1e-3, -8e-4, -0.01),
        'Distortion of the lens, plumb_bob: k1, k2, p1, p2, k3.',
        limits=(-10.0, 10.0),
        read_only=True,
    )
    camera_pose: tuple[float, ...] = parameter(
        (0.1, 0.0, 0.5, 0.0, 0.25, 0.0),
        'Where the camera is on the robot, x forward and z up: x, y, z in m, roll, pitch, yaw in '
        'rad. Positive pitch looks down.',
        limits=(-100.0, 100.0),
        read_only=True,
    )
    picture_noise: float = parameter(
        2.0,
        'Standard deviation of the noise of each pixel, of 255.',
        limits=(0.0, 64.0),
        read_only=True,
    )
    depth_noise: float = parameter(
        0.0,
        'Standard deviation of depths at 1 m, in m; it grows with the square of the depth, as that '
        'of stereo cameras does. 0.005 is that of a common one.',
        unit='1/m',
        limits=(0.0, 1.0),
        read_only=True,
    )
    depth_holes: float = parameter(
        0.0,
        'Share of the depth picture that is lost; then there are none at edges, either.',
        limits=(0.0, 1.0),
        read_only=True,
    )
    odometry_drift: tuple[float, ...] = parameter(
        (0.0, 0.0),
        'Standard deviation of what odometry is off by after 1 m, in m, and after turning by 1 '
        'rad, in rad; it grows with the square root.',
        limits=(0.0, 10.0),
        read_only=True,
    )
    seed: int = parameter(0, 'Of all that is random.', limits=(0, 2**31 - 1), read_only=True)

    def check(self) -> None:
        """Check the unit of the camera's angles, and its calibration."""
        require_radians(self.camera_pose)
        _ = self.camera  # CalibrationError is a ValueError

    @property
    def camera(self) -> CameraModel:
        """The robot's camera, with its principal point in the middle of the picture."""
        (width, height), f = self.picture_size, self.focal_length
        K = (f, 0, (width - 1) / 2, 0, f, (height - 1) / 2, 0, 0, 1)
        return CameraModel.of(width, height, K, self.distortion)
