"""Configuration of the locator: objects, camera pose, and noise of the measurements."""

from dataclasses import dataclass
from functools import cached_property

from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import named
from colortrack_ros.parameters import parameter

RANGE_METHODS = ('ground', 'size', 'depth', 'fused')
MOTIONS = ('plane', 'free', 'free_fall', 'still')
ALOFT = ('free', 'free_fall')
"""Motions of objects off the ground, whose range the ground does not give."""

THROWN_AT, ROLLED_AT = 5.0, 1.0
"""Standard deviations of the first speed [m/s] on each axis: balls are thrown by hand at 3 to 10
m/s, and rolled at walking pace. Assumed."""


VAGUE = 0.015
"""Standard deviation of a height [m] up to which somebody has measured it. Chosen: three times the
default."""

THINNEST = 1e-3
"""Least diameter of objects [m]: smaller ones are no blob for any camera, and in another unit
than meters most likely. Chosen."""


@dataclass(frozen=True)
class KindConfig(Config):
    """Properties of the objects of one color, NAME.diameter and so on."""

    diameter: float = parameter(
        0.0, 'Diameter of the objects; 0: not known.', unit='m', limits=(0.0, 100.0)
    )
    diameter_sigma: float = parameter(
        0.002, 'Standard deviation of diameter.', unit='m', limits=(0.0, 10.0)
    )
    height: float = parameter(
        -1.0,
        'Height of the center above the ground; negative: half the diameter.',
        unit='m',
        limits=(-1.0, 100.0),
    )
    height_sigma: float = parameter(
        0.005, 'Standard deviation of height.', unit='m', limits=(0.0, 10.0)
    )
    motion: str = parameter(
        'plane',
        'How they move: on the ground, anywhere as what is carried or flies, thrown or '
        'bouncing, or not at all.',
        choices=MOTIONS,
    )
    speed: float = parameter(
        -1.0,
        'Standard deviation of the speed, on each axis, of objects when they are first seen; '
        'negative: 5 m/s of motion free_fall, 1 m/s of others. Of things known to be slow less, '
        'such as 0.3: else what rolls slowly may be taken for standing.',
        unit='m/s',
        limits=(-1.0, 100.0),
    )
    wander: float = parameter(
        0.5,
        'Standard deviation, on each axis, of what the velocity changes by within a second.',
        unit='m/s',
        limits=(0.0, 100.0),
    )
    drag: float = parameter(
        0.02,
        'Of motion free_fall: deceleration by the air over squared speed: 0.02 of tennis balls and '
        'basketballs, 0.13 of table tennis balls, 0.2 of beach balls.',
        unit='1/m',
        limits=(0.0, 10.0),
    )
    drag_sigma: float = parameter(
        0.06,
        'Standard deviation of drag, which is learned as they fly.',
        unit='1/m',
        limits=(0.0, 10.0),
    )
    bounce: float = parameter(
        0.7,
        'Of motion free_fall: share of the vertical speed that is left after a bounce.',
        limits=(0.0, 1.0),
    )


@dataclass(frozen=True)
class Kind:
    """Objects of one color.

    :param name: of the color.
    :param config: their properties.
    """

    name: str
    config: KindConfig

    @property
    def center_height(self) -> float:
        """Height of the center above the ground [m]."""
        config = self.config
        return config.height if config.height >= 0 else config.diameter / 2

    @property
    def first_speed(self) -> float:
        """Standard deviation of the speed on each axis of objects when first seen [m/s]."""
        if self.config.speed >= 0:
            return self.config.speed
        return THROWN_AT if self.config.motion == 'free_fall' else ROLLED_AT


@dataclass(frozen=True)
class LocatorConfig(Config):
    """Configuration of how tracks are located in meters."""

    method: str = parameter(
        'ground',
        'Where the range comes from: the ground, the known diameter, a depth picture, or all.',
        choices=RANGE_METHODS,
    )
    colors: tuple[Kind, ...] = named(
        (), "Names of the detector's colors, in its order.", KindConfig, Kind
    )
    ground_height: float = parameter(
        0.0, 'Height of the ground in fixed_frame.', unit='m', limits=(-1e4, 1e4)
    )
    camera_pose_sigma: tuple[float, ...] = parameter(
        (0.01, 0.01, 0.01, 0.01, 0.01, 0.01),
        'Standard deviations of where the camera is on the robot: x, y, z in m, roll, pitch, yaw '
        'in rad.',
        limits=(0.0, 10.0),
    )
    pixel_noise: float = parameter(
        0.3,
        'Standard deviation on each axis, added to that which the detections bring.',
        unit='px',
        limits=(0.0, 100.0),
        audience=EXPERT,
    )
    eroded: float = parameter(
        2.55,
        'By how much blobs are smaller in diameter than what is seen: by 4/pi px for each pixel of '
        "the detector's erosion_size above 1. The boxes of networks are not.",
        unit='px',
        limits=(0.0, 100.0),
        audience=EXPERT,
    )
    size_noise: float = parameter(
        0.5,
        'Standard deviation of the diameter of a blob, independent in each picture.',
        unit='px',
        limits=(0.01, 100.0),
        audience=EXPERT,
    )
    size_sigma: float = parameter(
        0.5,
        'Standard deviation of the error that all blob diameters of an object share.',
        unit='px',
        limits=(0.0, 100.0),
        audience=EXPERT,
    )
    depth_noise: float = parameter(
        0.01,
        'Standard deviation of a measured depth, as a share of it, independent in each picture.',
        limits=(1e-4, 1.0),
        audience=EXPERT,
    )
    depth_sigma: float = parameter(
        0.005,
        'Standard deviation of the scale error that all depths share.',
        limits=(0.0, 1.0),
        audience=EXPERT,
    )
    odometry_sigma: tuple[float, ...] = parameter(
        (0.005, 0.005),
        'Standard deviation of what odometry is off by after 1 m, in m, and after turning by 1 '
        'rad, in rad.',
        limits=(0.0, 10.0),
        audience=EXPERT,
    )
    way_sigma: float = parameter(
        0.0,
        'Standard deviation of the scale error that all ways of odometry share: 0.05 for wheels '
        'whose radius nobody measured.',
        limits=(0.0, 1.0),
        audience=EXPERT,
    )
    stamp_sigma: float = parameter(
        0.001,
        'Standard deviation of the constant time by which stamps of pictures and those of odometry '
        'are apart; if they are farther, it becomes 0.05 s, and that is reported. 0: not at all.',
        unit='s',
        limits=(0.0, 1.0),
        audience=EXPERT,
    )
    max_range: float = parameter(
        20.0, 'Objects farther away are not located.', unit='m', limits=(0.1, 1e4)
    )

    @cached_property
    def vague(self) -> bool:
        """Whether the ground locates objects whose height may be too uncertain for it."""
        return self.method in ('ground', 'fused') and any(
            kind.config.height_sigma > VAGUE for kind in self.colors
        )

    @property
    def heightless(self) -> tuple[str, ...]:
        """Colors of which the height that the ground method needs is neither told nor follows."""
        if self.method not in ('ground', 'fused'):
            return ()
        return tuple(
            kind.name
            for kind in self.colors
            if kind.center_height == 0
            and kind.config.height < 0
            and kind.config.motion not in ALOFT
        )

    def check(self) -> None:
        """Check that each color has a source of range.

        :raises ValueError: the diameter that the method needs is missing, or too small.
        """
        for kind in self.colors:
            if 0 < kind.config.diameter < THINNEST:
                raise ValueError(
                    f'{kind.name}.diameter: expected 0, which is not known, or at least {THINNEST} '
                    f'm, got {kind.config.diameter:g}'
                )
            aloft = kind.config.motion in ALOFT
            if kind.config.diameter == 0 and (
                self.method == 'size' or (aloft and self.method in ('ground', 'fused'))
            ):
                raise ValueError(
                    f'{kind.name}.diameter: expected the diameter of the objects, above 0 m, which '
                    f'method {self.method} needs for motion {kind.config.motion}; got 0'
                )
