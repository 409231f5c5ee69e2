"""Lookup tables that label each pixel with its reference color.

The label depends only on a pixel's three bytes. The 2^24 colors are grouped into 2^16 cells (5 bits
of red, 6 of green, 5 of blue). Bounds of CIELAB over each cell tell whether all of its colors have
the same label; if so, one lookup per pixel settles it. Cells that a sphere's surface may cut are
computed, color by color, when first seen, and cached.
"""

from concurrent.futures import ThreadPoolExecutor
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.cells import cell_bounds
from colortrack_ros.detection.cells import cells_of
from colortrack_ros.detection.cells import corner_of
from colortrack_ros.detection.cells import distance_bounds
from colortrack_ros.detection.cells import IN_CELL
from colortrack_ros.detection.cells import least_squared
from colortrack_ros.detection.cells import TO_CELL
from colortrack_ros.detection.column_filter import ColumnFilter
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.label_image import WORD
from colortrack_ros.detection.pixels import rgb_of
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.survivors import Survivors

CUT, UNKNOWN = 255, 0
"""Entry of a cell whose colors may have different labels; entry of a color not yet computed. The
others are labels plus 1: pages of zeros are free until they are written."""

STRIP, LONG_STRIP = 1 << 18, 1 << 20
"""Pixels per strip with one thread and with several: `benchmark/detection.py` measures the time."""


def _has_16_bit_lut() -> bool:
    try:
        cv2.LUT(np.zeros((1, 1), np.uint16), np.zeros(1 << 16, np.uint8))
    except cv2.error:
        return False
    return True


HAS_16_BIT_LUT = _has_16_bit_lut()
"""Whether OpenCV can index a table by 16 bits: version 5 can, 4.6 cannot."""


def look_up(
    table: NDArray[np.uint8], index: NDArray[np.uint16], out: NDArray[np.uint8]
) -> NDArray[np.uint8]:
    """Look up 16-bit indices in a table of 65,536 bytes, into an array, which is returned."""
    if HAS_16_BIT_LUT:
        cv2.LUT(index, table, dst=out)
    else:
        out[...] = table.take(index, mode='clip')
    return out


class ColorTable:
    """Labels pixels: 0 for none of the colors, k + 1 for colors[k].

    A pixel belongs to a color if D < tolerance (2.2), computed in double precision as D^2 <
    tolerance^2. Within tolerance of several, it belongs to the one with the smallest D; at equal D,
    to the first. D is the distance (2.1) or, for an ellipsoid, the distance with each axis
    stretched so that D = tolerance on its surface. With samples, the nearest of them counts, and
    pixels at least as near to one of the color's others are excluded. An inverted color includes
    the pixels that belong neither to the color itself nor to one that is not inverted.

    :param colors: 1 to 254 reference colors.
    :param threads: number of threads per picture; the result does not depend on it.

    overlaps: whether pixels may be within tolerance of several colors that are not inverted.
    touched: (65536,) which cells contain any part of a color.
    holds_gray: whether any gray is within tolerance of a color.
    """

    def __init__(self, colors: tuple[ReferenceColor, ...], threads: int = 1) -> None:
        # Without the 16-bit table, NumPy does the lookup, which does not release the GIL.
        self._threads = threads if HAS_16_BIT_LUT else 1
        self._map = ThreadPoolExecutor(threads).map if self._threads > 1 else map
        self._samples = [np.array([color.lab, *color.samples]) for color in colors]
        self._others = [np.array(color.others).reshape(-1, 3) for color in colors]
        self._tolerance = np.array([color.tolerance for color in colors])
        self._inverted = [color.inverted for color in colors]
        self._stretch = self._tolerance[:, None] / [color.axes for color in colors]
        self._cells, touched = self._label_cells()
        self.overlaps = bool((touched[np.logical_not(self._inverted)].sum(axis=0) > 1).any())
        self.touched: NDArray[np.bool_] = np.logical_or.reduce(touched)
        self._column_filter = None if HAS_16_BIT_LUT else ColumnFilter(touched)
        self._survivors = Survivors(self.overlaps, HAS_16_BIT_LUT)
        self._exact = np.zeros(1 << 24, np.uint8)
        self._gray = self.label_colors(np.repeat(np.arange(256)[:, None], 3, axis=1))
        self.holds_gray = bool(self._gray.any())

    def _label_cells(self) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
        """(65536,) label of each cell, CUT if its colors must be looked up one by one.

        Also (colors, 65536), which cells contain any part of a color.
        """
        center, radius = cell_bounds()
        cells = np.zeros(1 << 16, np.uint8)
        may = np.zeros((len(self._samples), len(cells)), bool)
        for k, tolerance in enumerate(self._tolerance):
            nearest, farthest = distance_bounds(center, radius, self._samples[k], self._stretch[k])
            near_other, far_other = distance_bounds(
                center, radius, self._others[k], self._stretch[k]
            )
            touched = (nearest < tolerance**2) & (nearest < far_other)
            whole = (farthest < tolerance**2) & (farthest < near_other)
            if self._inverted[k]:
                touched, whole = ~whole, ~touched
            may[k] = touched
            cells[touched] = np.where((whole & (cells == 0))[touched], k + 1, CUT)
        return cells, may

    def label_colors(self, rgb: NDArray[np.integer]) -> NDArray[np.uint8]:
        """Label colors by the definition, one by one in double precision.

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

        For an inverted color, D / tolerance - 1, at most 1.

        :param rgb: (N, 3) red, green, blue.
        :param labels: (N,) of colors, not 0.
        """
        lab, closeness = lab_from_rgb(rgb), np.empty(len(rgb))
        found = set(labels.tolist())
        for label in found:
            mine, k = labels == label if len(found) > 1 else slice(None), label - 1
            distance = np.sqrt(self._squared(k, lab[mine])) / self._tolerance[k]
            closeness[mine] = np.nan_to_num(distance) - 1 if self._inverted[k] else 1 - distance
        return np.minimum(np.maximum(closeness, 0, out=closeness), 1, out=closeness)

    def _squared(self, k: int, lab: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N,) D^2 to a color; infinite if one of its others is at least as near."""
        columns, stretch = np.ascontiguousarray(lab.T), self._stretch[k]
        mine = least_squared(columns, self._samples[k], stretch)
        if len(self._others[k]):
            mine[least_squared(columns, self._others[k], stretch) <= mine] = np.inf
        return mine

    def label(
        self,
        picture: NDArray[np.uint8],
        encoding: str,
        erosion: int = 1,
        old: LabelImage | None = None,
    ) -> LabelImage:
        """Label a picture.

        :param picture: (H, W, channels) or (H, W), not empty; rows may be padded.
        :param erosion: side of the square of a subsequent erosion [px]: pixels that it removes need
            not be labeled.
        :param old: an image that is no longer needed, whose memory may be reused.
        """
        height, width = picture.shape[:2]
        if encoding == 'mono8':
            image = LabelImage.empty(height, width)
            cv2.LUT(picture.reshape(height, width), self._gray, dst=image.pixels)
            return image

        label_rows = partial(self._label_strips, encoding=encoding)
        label_pixels = partial(self._label_pixels, encoding=encoding)
        survivors = self._survivors.label(picture, erosion, label_rows, label_pixels, old)
        return survivors or self._look_closer(picture, encoding, label_rows(picture))[0]

    def _label_pixels(
        self, pixels: NDArray[np.uint8], encoding: str
    ) -> tuple[LabelImage, NDArray[np.intp]]:
        """Label a few pixels; as _look_closer."""
        image = LabelImage.empty(*pixels.shape[:2])
        look_up(self._cells, cells_of(pixels, encoding), image.pixels)
        return self._look_closer(pixels, encoding, image)

    def _look_closer(
        self, picture: NDArray[np.uint8], encoding: str, image: LabelImage
    ) -> tuple[LabelImage, NDArray[np.intp]]:
        """Replace CUT by the label of the pixel's exact color, in place.

        :returns: the image and the words that are not empty, which it then knows.
        """
        words, found = image.content()
        image.filled = words
        (cut,) = (found.reshape(-1) == CUT).nonzero()
        if cut.size:
            word = words.take(cut >> 3)
            position = word * WORD + (cut & 7)
            pixel = position - word // (image.stride // WORD) * (image.stride - image.width)
            pixels = picture.reshape(-1, picture.shape[2]).take(pixel, axis=0)
            image.padded.reshape(-1)[position] = self._exact_labels(pixels, encoding)
        return image, words

    def _label_strips(self, picture: NDArray[np.uint8], encoding: str) -> LabelImage:
        """Label a picture, with CUT for undecided pixels, strip by strip.

        Strips stay in the processor's cache between steps. With several threads they are longer:
        switching threads costs more than the cache saves.
        """
        height, width = picture.shape[:2]
        image = LabelImage.empty(height, width)
        strips = round(height * width / (STRIP if self._threads == 1 else LONG_STRIP))
        rows = -(-height // min(max(strips, 1), height))

        def label_strip(top: int) -> None:
            bottom = top + rows
            self._label_strip(picture[top:bottom], encoding, image.strip(top, bottom))

        list(self._map(label_strip, range(0, height, rows)))
        return image

    def _label_strip(self, picture: NDArray[np.uint8], encoding: str, image: LabelImage) -> None:
        if self._column_filter is None:
            look_up(self._cells, cells_of(picture, encoding), image.pixels)
            return
        image.padded[...] = 0
        for left, right in self._column_filter.parts(picture, encoding):
            cells = cv2.cvtColor(picture[:, left:right], TO_CELL[encoding]).view(np.uint16)
            look_up(self._cells, cells[..., 0], image.pixels[:, left:right])

    def _exact_labels(self, pixels: NDArray[np.uint8], encoding: str) -> NDArray[np.uint8]:
        """(N,) labels of pixels, (N, channels), by their exact colors."""
        rgb = rgb_of(pixels, encoding).astype(np.int32)
        color = rgb[:, 0] << 16 | rgb[:, 1] << 8 | rgb[:, 2]
        labels = self._exact.take(color)
        unknown = color[labels == UNKNOWN]
        if unknown.size:
            self._compute_cells(unknown)
            labels = self._exact.take(color)
        return labels - 1

    def _compute_cells(self, colors: NDArray[np.int32]) -> None:
        """Label and cache all colors of the cells that contain the given colors.

        :param colors: (N,) red << 16 | green << 8 | blue.
        """
        cells = np.unique(colors >> 8 & 0xF800 | colors >> 5 & 0x07E0 | colors >> 3 & 0x001F)
        rgb = (corner_of(cells)[:, None] + IN_CELL).reshape(-1, 3)
        labels = self.label_colors(rgb)
        self._exact[rgb @ [1 << 16, 1 << 8, 1]] = labels + 1
        labels = labels.reshape(len(cells), -1)
        whole = (labels == labels[:, :1]).all(axis=1)
        self._cells[cells[whole]] = labels[whole, 0]
