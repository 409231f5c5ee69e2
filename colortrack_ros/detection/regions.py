"""Regions of the picture to search or to ignore."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.reference import expect
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import parameter
from colortrack_ros.picture_files import read_picture

LEAST_SEARCHED = 5
"""Least area that is worth searching [px]: corners in shares of the picture, 0 to 1, where pixels
are expected, leave four."""


@dataclass(frozen=True)
class Region:
    """A polygon to search or to ignore.

    :param name: of the region.
    :param polygon: (u, v) of at least three corners [px].
    :param ignore: whether to ignore it.
    """

    name: str
    polygon: tuple[tuple[float, float], ...]
    ignore: bool = False

    def __post_init__(self) -> None:
        name = f'{self.name}.polygon'
        expect(len(self.polygon) >= 3, name, self.polygon, 'at least three corners (u, v)')
        valid = np.shape(self.polygon)[1:] == (2,) and bool(np.isfinite(self.polygon).all())
        expect(valid, name, self.polygon, 'corners (u, v) of finite numbers')
        expect(np.abs(self.polygon).max() < 1e6, name, self.polygon, 'corners within 1e6 px')


@dataclass(frozen=True)
class RegionConfig(Config):
    """Parameters of each NAME in ``regions``."""

    polygon: tuple[float, ...] = parameter(float, 'Corners [u1, v1, u2, v2, ...].', unit='px')
    ignore: bool = parameter(
        False, 'True: nothing is detected inside. False: nothing is detected outside.'
    )


def region_of(name: str, config: RegionConfig) -> Region:
    """The region described by the parameters of a NAME.

    :raises ValueError: if the polygon has too few corners, or a coordinate is missing.
    """
    corners = config.polygon
    pairs = f'{name}.polygon'
    expect(len(corners) % 2 == 0, pairs, len(corners), 'pairs of u and v, an even number of them')
    return Region(name, tuple(zip(corners[::2], corners[1::2], strict=True)), config.ignore)


class Regions:
    """Where blobs may be: inside a region to search, if there are any, and in none to ignore.

    :param regions: polygons.
    :param mask: path of a picture that is dark in places to ignore, empty for none; it is scaled to
        the frames.
    :raises ValueError: if there is no such picture.
    """

    def __init__(self, regions: tuple[Region, ...], mask: str) -> None:
        self._regions = regions
        self._picture = _read_mask(mask) if mask else None
        self._allowed: LabelImage | None = None

    def __bool__(self) -> bool:
        """Whether any part of the picture is excluded."""
        return bool(self._regions) or self._picture is not None

    def trouble(self, least_area: int) -> str:
        """Why nothing can be found in pictures like the last one; empty if it can.

        :param least_area: of a blob [px].
        """
        if self._allowed is None:
            return ''
        area, (height, width) = self._area, self._allowed.pixels.shape
        if area >= max(least_area, LEAST_SEARCHED):
            return ''
        return (
            f'regions and mask leave {area} of the {width}x{height} pixels to look in: expected '
            'corners in pixels of these pictures'
        )

    def apply(self, image: LabelImage) -> None:
        """Clear the labels outside, in place."""
        if self._allowed is None or self._allowed.padded.shape != image.padded.shape:
            self._allowed = self._draw(*image.pixels.shape)
        np.bitwise_and(image.words, self._allowed.words, out=image.words)

    def _draw(self, height: int, width: int) -> LabelImage:
        look_in = [region for region in self._regions if not region.ignore]
        allowed = LabelImage.empty(height, width)
        canvas: NDArray[np.uint8] = np.full((height, width), 0 if look_in else 255, np.uint8)
        for region in sorted(self._regions, key=lambda region: region.ignore):
            corners = np.rint(region.polygon).astype(np.int32)
            cv2.fillPoly(canvas, [corners], (0 if region.ignore else 255,))
        if self._picture is not None:
            scaled = cv2.resize(self._picture, (width, height), interpolation=cv2.INTER_NEAREST)
            canvas[scaled < 128] = 0
        allowed.pixels[...] = canvas
        self._area = int(np.count_nonzero(canvas))
        return allowed


def _read_mask(path: str) -> NDArray[np.uint8]:
    """Read a picture in gray.

    :raises ValueError: if there is none, or it cannot be decoded.
    """
    try:
        return read_picture(path, cv2.IMREAD_GRAYSCALE)
    except ValueError as error:
        raise ValueError(f'mask: expected the path of a picture, got {path!r}: {error}') from error
