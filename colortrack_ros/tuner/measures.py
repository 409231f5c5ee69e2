"""Measures to set the sliders by: the blobs before limits, and the colors of the picture."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.cells import lab_of_cells
from colortrack_ros.detection.extent import find_extent
from colortrack_ros.detection.extent import sample_colors
from colortrack_ros.detection.lab import rgb_from_lab
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.named import choose
from colortrack_ros.detection.reference import apart_from
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.shades import reach_of
from colortrack_ros.detection.shades import with_shades
from colortrack_ros.detection.shape import MEASURES
from colortrack_ros.detection.strangers import find_own_extent
from colortrack_ros.encodings import plain

MOST_MEASURED = 200
"""How many blobs of a picture are measured, the largest first: a screen shows no more."""

BIN = 3.0
"""Side of a bin in the a-b plane [CIELAB units]: a little more than the just noticeable difference,
2.3 (Mahy 1994)."""


REACH_BINS, REACH_SPAN = 40, 100.0
"""Number of bars above the slider of a tolerance, and its end [CIELAB units]: the distance of black
from white."""


def blobs_before_limits(labels: NDArray[np.uint8]) -> list[dict[str, Any]]:
    """All blobs of a mask, of any size and shape, largest first.

    :param labels: (H, W) from the detector.
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
        reference color its samples and what is not it, each [L, a, b], its half axes, those that
        the detector would find where none are given, None where it would not, and its reach.
    """
    frame = plain(frame)
    sample, counts = sample_colors(frame.image, frame.encoding)
    (filled,) = counts.nonzero()
    lab, number = lab_of_cells(filled), counts[filled]
    squares, square = np.unique(np.floor(lab[:, 1:] / BIN), axis=0, return_inverse=True)
    square = square.reshape(-1)
    pixels = np.bincount(square, number)
    mean = [np.bincount(square, number * lab[:, axis]) / pixels for axis in range(3)]
    rgb = rgb_from_lab(np.stack(mean, axis=1))
    middle = (squares + 0.5) * BIN
    colors = [
        _place_of(k, config.colors, sample, counts, lab, number) for k in range(len(config.colors))
    ]
    return {'cells': np.column_stack([middle, pixels, rgb]).round(1).tolist(), 'colors': colors}


def _place_of(
    k: int,
    given: Sequence[ReferenceColor],
    sample: NDArray[np.uint16],
    counts: NDArray[np.float64],
    cells: NDArray[np.float64],
    number: NDArray[np.float64],
) -> dict[str, Any]:
    """A reference color, in a picture with a histogram over the cells of the color table.

    :param k, given: which of the given colors it is.
    :param sample: of the picture, see sample_colors().
    :param cells: (N, 3) CIELAB of those with pixels.
    :param number: (N,) of their pixels.
    """
    color, apart = given[k], apart_from(given, k)
    if color.preset:
        taken = [other for other in given if not other.is_sought]
        shown = choose(sample, counts, color, taken, partial(find_extent, counts, apart=apart))
        color = replace(color, lab=shown.lab) if shown else color
    lab, axes = color.lab, color.axes if not color.is_sought else None
    if axes is None:
        if color.is_sampled:
            extent = find_extent(counts, color.lab, color.samples, color.others, apart=apart)
        else:
            extent, apart = find_own_extent(sample, counts, color.lab, apart)
            reach = extent and reach_of(sample, counts, extent, apart)
            extent = extent and with_shades(extent, reach or 1.0)
        lab, axes = (extent.lab, extent.axes) if extent else (lab, None)
    samples = [lab, *color.samples]
    return {
        'name': color.name,
        'samples': samples,
        'others': color.others,
        'axes': axes,
        'reach': _reach(samples, axes, color.tolerance_lab is not None, cells, number),
    }


def _reach(
    samples: Sequence[Triple],
    axes: Triple | None,
    each_axis: bool,
    cells: NDArray[np.float64],
    number: NDArray[np.float64],
) -> list[list[list[float]]]:
    """What the sliders of a color's reach include and exclude: pixels by their distance to the
    color.

    :param each_axis: along L, a and b, of pixels within reach along the two others.
    :returns: for each slider, the pixels within reach and those beyond it, in REACH_BINS.
    """
    away = np.abs(cells[:, None] - np.array(samples))
    scaled = (away / (axes or (np.inf,) * 3)) ** 2
    nearest = scaled.sum(axis=2).argmin(axis=1)
    away, scaled = (np.take_along_axis(a, nearest[:, None, None], 1)[:, 0] for a in (away, scaled))
    inside = (scaled.sum(axis=1) < 1) & (axes is not None)
    if each_axis:
        cuts = [(away[:, k], np.delete(scaled, k, axis=1).sum(axis=1) < 1) for k in range(3)]
    else:
        cuts = [(np.linalg.norm(away, axis=1), np.ones(len(cells), bool))]
    bars = []
    for distance, shown in cuts:
        place = (distance * REACH_BINS / REACH_SPAN).astype(int).clip(0, REACH_BINS - 1)
        both = (
            np.bincount(place, number * (shown & part), REACH_BINS) for part in (inside, ~inside)
        )
        bars.append([counts.tolist() for counts in both])
    return bars
