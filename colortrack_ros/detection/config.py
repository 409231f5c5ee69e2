"""Detector parameters: what to detect, and how a mask becomes blobs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.growth import FEWEST_PIXELS
from colortrack_ros.detection.methods import METHODS
from colortrack_ros.detection.methods.background import BackgroundSubtractionConfig
from colortrack_ros.detection.methods.channel_difference import ChannelDifferenceConfig
from colortrack_ros.detection.methods.color_config import ColorDistanceConfig
from colortrack_ros.detection.morphology import MorphologyConfig
from colortrack_ros.detection.reference import expect
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
    """The parameters of all methods, and of the steps after them.

    A dataclass lists the fields of its last base first.
    """

    split: bool = parameter(False, 'Whether blobs of touching objects are cut at their necks.')
    regions: tuple[Region, ...] = named(
        (), 'Names of the regions to look in or to ignore.', RegionConfig, region_of
    )
    mask: str = parameter('', 'Path of a picture that is dark where not to look; empty for none.')
    method: str = parameter('color', 'How objects are told from the rest.', choices=METHODS)

    @property
    def erodes_at_once(self) -> bool:
        """Whether labels may be eroded while they are made, and no region cuts blobs.

        If one does, the covariance needs the labels that the erosion removes.
        """
        return super().erodes_at_once and not self.regions and not self.mask

    @property
    def of_small_things(self) -> list[int]:
        """The colors of which the erosion and the default of min_area alone hide small things."""
        least = self.areas()[0, 1:]
        return [k for k in super().of_small_things if least[k] <= FEWEST_PIXELS]

    def check(self) -> None:
        """Require that the least area of each color does not exceed its greatest."""
        super().check()
        for color, least, most in zip(self.colors, *self.areas()[:, 1:].tolist(), strict=True):
            expect(least <= most, f'{color.name}.max_area', most, f'at least {least} px')

    def areas(self) -> NDArray[np.int64]:
        """(2, colors + 1) least and greatest area of blobs, by label [px]."""
        own = self.colors if self.method == 'color' else ()
        areas = np.tile(np.array([[self.min_area], [self.max_area]]), len(self.colors) + 1)
        for k, color in enumerate(own, start=1):
            areas[:, k] = color.min_area or self.min_area, color.max_area or self.max_area
        return areas
