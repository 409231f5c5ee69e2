"""What a person sets: what to look for, and how a mask becomes blobs."""

from dataclasses import dataclass

from colortrack_ros.detection.methods import METHODS
from colortrack_ros.detection.methods.background import BackgroundSubtractionConfig
from colortrack_ros.detection.methods.channel_difference import ChannelDifferenceConfig
from colortrack_ros.detection.methods.color import ColorDistanceConfig
from colortrack_ros.detection.morphology import MorphologyConfig
from colortrack_ros.detection.regions import Region
from colortrack_ros.detection.regions import region_of
from colortrack_ros.detection.regions import RegionConfig
from colortrack_ros.detection.shape import ShapeConfig
from colortrack_ros.parameters import named
from colortrack_ros.parameters import parameter


@dataclass(frozen=True)
class DetectorConfig(
    BackgroundSubtractionConfig,
    ChannelDifferenceConfig,
    ColorDistanceConfig,
    MorphologyConfig,
    ShapeConfig,
):
    """How a picture becomes detections: what the methods and the steps after them declare.

    A dataclass lists the fields of its last base first.
    """

    split: bool = parameter(False, 'Whether blobs of touching objects are cut at their necks.')
    regions: tuple[Region, ...] = named(
        (), 'Names of the regions to look in or to ignore.', RegionConfig, region_of
    )
    mask: str = parameter('', 'Path of a picture that is dark where not to look; empty for none.')
    method: str = parameter('color', 'How objects are told from the rest.', choices=METHODS)
