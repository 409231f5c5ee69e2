"""What the sliders are set by: the blobs before limits, and the colors of the picture."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.color_table import cell_bounds
from colortrack_ros.detection.extent import count_colors
from colortrack_ros.detection.extent import find_extent
from colortrack_ros.detection.lab import rgb_from_lab
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.shape import MEASURES
from colortrack_ros.encodings import plain

MOST_MEASURED = 200
"""Blobs of a picture that are measured, the largest: a screen shows no more."""

BIN = 3.0
"""Side of a square of the a-b plane [CIELAB units]: a little more than what is just seen as
different, 2.3 (Mahy 1994)."""


def blobs_before_limits(labels: NDArray[np.uint8]) -> list[dict[str, Any]]:
    """Every blob of a mask, whatever its size and shape, largest first.

    :param labels: (H, W) of the detector.
    :returns: label, box [u, v, width, height], area, and the measure of each limit of the shape.
    """
    image = LabelImage.empty(*labels.shape)
    image.pixels[...] = labels
    blobs = find_blobs(image, 1)
    blobs = blobs.take(np.arange(len(blobs.area)) < MOST_MEASURED)
    if not len(blobs.area):
        return []
    columns = {'area': blobs.area} | {name: measure(blobs) for name, measure in MEASURES.items()}
    table = {name: np.round(column, 4).tolist() for name, column in columns.items()}
    table |= {'label': blobs.label.tolist(), 'box': blobs.box.tolist()}
    return [dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True)]


def plane_of(frame: Frame, config: DetectorConfig) -> dict[str, Any]:
    """The colors of a picture in the a-b plane, and where the reference colors are.

    :returns: cells, [a, b, pixels, red, green, blue] of each square with pixels; and for each
        reference color its samples and what is not it, each [L, a, b], and its half axes, those
        that the detector would find where none are given, None where it would not.
    """
    frame = plain(frame)
    counts = count_colors(frame.image, frame.encoding)
    (filled,) = counts.nonzero()
    lab, number = cell_bounds()[0].T[filled], counts[filled]
    squares, square = np.unique(np.floor(lab[:, 1:] / BIN), axis=0, return_inverse=True)
    square = square.reshape(-1)
    pixels = np.bincount(square, number)
    mean = [np.bincount(square, number * lab[:, axis]) / pixels for axis in range(3)]
    rgb = rgb_from_lab(np.stack(mean, axis=1))
    middle = (squares + 0.5) * BIN
    colors = [_place_of(color, counts) for color in config.colors]
    return {'cells': np.column_stack([middle, pixels, rgb]).round(1).tolist(), 'colors': colors}


def _place_of(color: ReferenceColor, counts: NDArray[np.float64]) -> dict[str, Any]:
    """A reference color, in a picture with so many pixels in each cell of the color table."""
    lab, axes = color.lab, color.axes if not color.is_sought else None
    if axes is None:
        extent = find_extent(counts, color.lab, color.samples, color.others)
        lab, axes = (extent.lab, extent.axes) if extent else (lab, None)
    return {
        'name': color.name,
        'samples': [lab, *color.samples],
        'others': color.others,
        'axes': axes,
    }
