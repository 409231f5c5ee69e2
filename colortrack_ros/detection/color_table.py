"""Which reference color each pixel belongs to, from tables.

The answer depends on a pixel's three bytes alone. The 2^24 colors are grouped into 2^16 cells
(5 bits of red, 6 of green, 5 of blue), and a bound of CIELAB over each cell tells whether all of
its colors belong to the same reference color or none. One look-up for a pixel settles those. A
cell that a sphere's surface may cut is computed, color by color, when it is first seen, and
remembered.
"""

from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.column_filter import ColumnFilter
from colortrack_ros.detection.lab import cube_root_or_line_slope
from colortrack_ros.detection.lab import lab_from_linear
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.lab import LINEAR
from colortrack_ros.detection.lab import WHITE_TO_ONE
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.label_image import WORD
from colortrack_ros.detection.pixels import rgb_of
from colortrack_ros.detection.reference import ReferenceColor

CELLS = 1 << 16
"""5 bits of red, 6 of green, 5 of blue."""

CUT, UNKNOWN = 255, 0
"""Entry of a cell whose colors may not belong together; of a color not yet computed, the label of
one that is having 1 added: pages of zeros cost nothing before they are written to."""

_TO_CELL = {
    'bgr8': cv2.COLOR_BGR2BGR565,
    'rgb8': cv2.COLOR_RGB2BGR565,
    'bgra8': cv2.COLOR_BGRA2BGR565,
    'rgba8': cv2.COLOR_RGBA2BGR565,
}
_IN_CELL = np.stack(np.meshgrid(range(8), range(4), range(8), indexing='ij'), -1).reshape(-1, 3)
STRIP, LONG_STRIP = 1 << 18, 1 << 20
"""Pixels that are worked on at a time, by one thread and by several; they set the time alone, which
`python benchmark/detection.py` measures."""

_MARGIN = 1e-6
"""Added to the bounds for rounding, which is below 1e-11 of a CIELAB unit in double precision."""


def _has_16_bit_lut() -> bool:
    try:
        cv2.LUT(np.zeros((1, 1), np.uint16), np.zeros(1 << 16, np.uint8))
    except cv2.error:
        return False
    return True


HAS_16_BIT_LUT = _has_16_bit_lut()
"""OpenCV 5 indexes a table by 16 bits, 4.6 does not."""


def _corner(cell: NDArray[np.intp]) -> NDArray[np.intp]:
    """(N, 3), the least red, green, blue of each cell."""
    return np.stack([cell >> 11 << 3, (cell >> 5 & 63) << 2, (cell & 31) << 3], axis=-1)


@lru_cache(maxsize=1)
def cell_bounds() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """CIELAB over each cell lies within center plus and minus radius, axis by axis.

    L is monotone in red, green and blue. For a and b the mean value theorem bounds the way from
    the middle of the cell by the largest slope in it, and f' of CIE 1976 falls monotonically.

    :returns: centers and radii, both (3, 65536).
    """
    low = _corner(np.arange(1 << 16))
    low_linear, high_linear = LINEAR[low], LINEAR[low + _IN_CELL[-1]]
    center = lab_from_linear((low_linear + high_linear) / 2)
    half = (high_linear - low_linear) / 2
    steep = cube_root_or_line_slope(low_linear @ WHITE_TO_ONE.T)
    flat = cube_root_or_line_slope(high_linear @ WHITE_TO_ONE.T)
    radius = np.empty_like(center)
    lightness = np.stack([lab_from_linear(end)[:, 0] for end in (low_linear, high_linear)])
    center[:, 0] = lightness.mean(axis=0)
    radius[:, 0] = np.ptp(lightness, axis=0) / 2
    for axis, (plus, minus, scale) in enumerate(((0, 1, 500), (1, 2, 200)), start=1):
        rising = steep[:, [plus]] * WHITE_TO_ONE[plus] - flat[:, [minus]] * WHITE_TO_ONE[minus]
        falling = flat[:, [plus]] * WHITE_TO_ONE[plus] - steep[:, [minus]] * WHITE_TO_ONE[minus]
        slope = np.maximum(np.abs(rising), np.abs(falling))
        radius[:, axis] = scale * (slope * half).sum(axis=1)
    return np.ascontiguousarray(center.T), np.ascontiguousarray(radius.T) + _MARGIN


def _bounds(
    center: NDArray[np.float64],
    radius: NDArray[np.float64],
    samples: NDArray[np.float64],
    stretch: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(65536,) each: between which D^2 to the nearest sample lies over each cell."""
    nearest, farthest = np.full((2, center.shape[1]), np.inf)
    for sample in samples:
        offset = np.abs(center - sample[:, None])
        near = ((np.maximum(offset - radius, 0) * stretch[:, None]) ** 2).sum(axis=0)
        np.minimum(nearest, near, out=nearest)
        far = (((offset + radius) * stretch[:, None]) ** 2).sum(axis=0)
        np.minimum(farthest, far, out=farthest)
    return nearest, farthest


def cells_of(picture: NDArray[np.uint8], encoding: str) -> NDArray[np.uint16]:
    """(H, W) the cell of each pixel."""
    code = _TO_CELL.get(encoding, cv2.COLOR_GRAY2BGR565)
    return cv2.cvtColor(picture, code).view(np.uint16).reshape(picture.shape[:2])


class ColorTable:
    """Labels pixels: 0 for none of the colors, k + 1 for colors[k].

    A pixel belongs to a color where D < tolerance (2.2), computed in double precision as D^2 <
    tolerance^2; within tolerance of several, to the one with the smallest D; at equal D, to the
    first. D is the distance (2.1) or, for an ellipsoid, the distance with each axis stretched so
    that D = tolerance on its surface. Of a color with samples it is that to the nearest of them,
    and a pixel that is at least as near to one of its others does not belong to it. To an inverted
    color belong the pixels that do not belong to the color itself, nor to one that is not inverted.

    :param colors: 1 to 254 reference colors.
    :param threads: that work on a picture at the same time; the result is the same.

    overlaps: whether a pixel may be within tolerance of several that are not inverted.
    """

    def __init__(self, colors: tuple[ReferenceColor, ...], threads: int = 1) -> None:
        # Without the 16-bit table NumPy looks up, which does not let go of the interpreter.
        self._threads = threads if HAS_16_BIT_LUT else 1
        self._map = ThreadPoolExecutor(threads).map if self._threads > 1 else map
        self._samples = [np.array([color.lab, *color.samples]) for color in colors]
        self._others = [np.array(color.others).reshape(-1, 3) for color in colors]
        self._tolerance = np.array([color.tolerance for color in colors])
        self._inverted = [color.inverted for color in colors]
        self._stretch = self._tolerance[:, None] / [color.axes for color in colors]
        self._cells, touched = self._label_cells()
        self.overlaps = bool((touched[np.logical_not(self._inverted)].sum(axis=0) > 1).any())
        self._column_filter = None if HAS_16_BIT_LUT else ColumnFilter(touched)
        self._exact = np.zeros(1 << 24, np.uint8)
        self._gray = self.label_colors(np.repeat(np.arange(256)[:, None], 3, axis=1))

    def _label_cells(self) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
        """(65536,) label of each cell, CUT where a look at the single color is needed.

        And (colors, 65536), which cells hold something of a color.
        """
        center, radius = cell_bounds()
        cells = np.zeros(1 << 16, np.uint8)
        may = np.zeros((len(self._samples), len(cells)), bool)
        for k, tolerance in enumerate(self._tolerance):
            nearest, farthest = _bounds(center, radius, self._samples[k], self._stretch[k])
            near_other, far_other = _bounds(center, radius, self._others[k], self._stretch[k])
            touched = (nearest < tolerance**2) & (nearest < far_other)
            whole = (farthest < tolerance**2) & (farthest < near_other)
            if self._inverted[k]:
                touched, whole = ~whole, ~touched
            may[k] = touched
            cells[touched] = np.where((whole & (cells == 0))[touched], k + 1, CUT)
        return cells, may

    def label_colors(self, rgb: NDArray[np.integer]) -> NDArray[np.uint8]:
        """The definition, color by color in double precision.

        :param rgb: (N, 3) red, green, blue.
        :returns: (N,) labels.
        """
        lab = lab_from_rgb(rgb)
        labels = np.zeros(len(rgb), np.uint8)
        smallest = np.full(len(rgb), np.inf)
        for k, tolerance in enumerate(self._tolerance):
            squared = self._squared(k, lab)
            if self._inverted[k]:
                labels[(squared >= tolerance**2) & (labels == 0)] = k + 1
                continue
            nearer = (squared < tolerance**2) & (squared < smallest)
            labels[nearer] = k + 1
            smallest[nearer] = squared[nearer]
        return labels

    def closeness(self, rgb: NDArray[np.uint8], labels: NDArray[np.uint8]) -> NDArray[np.float64]:
        """1 - D / tolerance to the color of the label; 0 out of tolerance.

        To an inverted one D / tolerance - 1, at most 1.

        :param rgb: (N, 3) red, green, blue.
        :param labels: (N,) of colors, not 0.
        """
        lab = lab_from_rgb(rgb)
        distance = np.zeros(len(labels))
        for label in set(labels.tolist()):
            mine, k = labels == label, label - 1
            distance[mine] = np.sqrt(self._squared(k, lab[mine])) / self._tolerance[k]
            if self._inverted[k]:
                distance[mine] = 2 - distance[mine]
        return np.clip(1 - distance, 0, 1)

    def _squared(self, k: int, lab: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N,) D^2 to a color; infinite where something that is not it is as near."""
        mine, other = np.full((2, len(lab)), np.inf)
        for least, samples in ((mine, self._samples[k]), (other, self._others[k])):
            for sample in samples:
                lightness, a, b = ((lab - sample) * self._stretch[k]).T
                np.minimum(least, lightness * lightness + a * a + b * b, out=least)
        mine[other <= mine] = np.inf
        return mine

    def label(self, picture: NDArray[np.uint8], encoding: str) -> LabelImage:
        """The labels of a picture.

        The strips stay in the processor's cache from step to step. Those of several threads are
        longer: handing over the interpreter costs more than that saves.

        :param picture: (H, W, channels) or (H, W), not empty; rows may be padded.
        """
        height, width = picture.shape[:2]
        image = LabelImage.empty(height, width)
        strips = round(height * width / (STRIP if self._threads == 1 else LONG_STRIP))
        rows = -(-height // min(max(strips, 1), height))

        def label_strip(top: int) -> NDArray[np.intp]:
            bottom = top + rows
            filled = self._label_strip(picture[top:bottom], encoding, image.strip(top, bottom))
            return filled + top * (image.stride // WORD)

        if encoding == 'mono8':
            cv2.LUT(picture.reshape(height, width), self._gray, dst=image.pixels)
        else:
            image.filled = np.concatenate(list(self._map(label_strip, range(0, height, rows))))
        return image

    def _label_strip(
        self, picture: NDArray[np.uint8], encoding: str, image: LabelImage
    ) -> NDArray[np.intp]:
        """Set the labels of an image.

        :returns: the words that may hold any.
        """
        if self._column_filter is None:
            cv2.LUT(cells_of(picture, encoding), self._cells, dst=image.pixels)
        else:
            image.padded[...] = 0
            parts = self._column_filter.parts(picture, encoding)
            for left, right in parts:
                cells = cv2.cvtColor(picture[:, left:right], _TO_CELL[encoding]).view(np.uint16)
                image.pixels[:, left:right] = self._cells.take(cells[..., 0], mode='clip')
        words, found = image.content()
        (cut,) = (found.reshape(-1) == CUT).nonzero()
        if cut.size:
            self._look_closer(picture, encoding, image, words, cut)
        return words

    def _look_closer(
        self,
        picture: NDArray[np.uint8],
        encoding: str,
        image: LabelImage,
        words: NDArray[np.intp],
        cut: NDArray[np.intp],
    ) -> None:
        """Replace CUT by the label of the single color, in place.

        :param words: numbers of the words that are not empty.
        :param cut: positions of CUT in them, one behind the other.
        """
        position = (words * WORD)[cut >> 3] + (cut & 7)
        row = words // (image.stride // WORD)
        pixel = position - (row * (image.stride - image.width))[cut >> 3]
        pixels = picture.reshape(-1, picture.shape[2]).take(pixel, axis=0)
        rgb = rgb_of(pixels, encoding).astype(np.int32)
        color = rgb[:, 0] << 16 | rgb[:, 1] << 8 | rgb[:, 2]
        labels = self._exact.take(color)
        unknown = color[labels == UNKNOWN]
        if unknown.size:
            self._compute_cells(unknown)
            labels = self._exact.take(color)
        image.padded.reshape(-1)[position] = labels - 1

    def _compute_cells(self, colors: NDArray[np.int32]) -> None:
        """Label every color of the cells that the given colors are in, and remember it.

        :param colors: (N,) red << 16 | green << 8 | blue.
        """
        cells = np.unique(colors >> 8 & 0xF800 | colors >> 5 & 0x07E0 | colors >> 3 & 0x001F)
        rgb = (_corner(cells)[:, None] + _IN_CELL).reshape(-1, 3)
        labels = self.label_colors(rgb)
        self._exact[rgb @ [1 << 16, 1 << 8, 1]] = labels + 1
        labels = labels.reshape(len(cells), -1)
        whole = (labels == labels[:, :1]).all(axis=1)
        self._cells[cells[whole]] = labels[whole, 0]
