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
from colortrack_ros.detection.cells import cell_of
from colortrack_ros.detection.cells import CELLS
from colortrack_ros.detection.cells import cells_of
from colortrack_ros.detection.cells import colors_in
from colortrack_ros.detection.cells import distance_bounds
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

FEW_CELLS = 32
"""Most new cells in one picture of which all colors are labeled, in 1.5 ms, if colors change; of
more, as in the first picture and after a change, those that occur, a thirtieth of them. Chosen."""

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
    :param most_whole: most new cells in one picture of which all colors are labeled.

    overlaps: whether pixels may be within tolerance of several colors that are not inverted.
    touched: (65536,) which cells contain any part of a color.
    holds_gray: whether any gray is within tolerance of a color.
    """

    def __init__(
        self, colors: tuple[ReferenceColor, ...], threads: int = 1, most_whole: int = CELLS
    ) -> None:
        # Without the 16-bit table, NumPy does the lookup, which does not release the GIL.
        self._threads = threads if HAS_16_BIT_LUT else 1
        self._map = ThreadPoolExecutor(threads).map if self._threads > 1 else map
        self._colors, self._most_whole = tuple[ReferenceColor, ...](), most_whole
        self._may, self._whole = np.zeros((2, len(colors), CELLS), bool)
        self._cells = np.zeros(CELLS, np.uint8)
        self._exact, self._is_known = np.zeros(1 << 24, np.uint8), np.zeros(CELLS, bool)
        self.overlaps, self._survivors = False, Survivors(False, HAS_16_BIT_LUT)
        self.take(colors)

    def take(self, colors: tuple[ReferenceColor, ...]) -> None:
        """Replace the colors by as many; what those that change do not touch stays known."""
        changed = [k for k, new in enumerate(colors) if (new,) != self._colors[k : k + 1]]
        self._colors = colors
        self._samples = [np.array([color.lab, *color.samples]) for color in colors]
        self._others = [np.array(color.others).reshape(-1, 3) for color in colors]
        self._tolerance = np.array([color.tolerance for color in colors])
        self._inverted = np.array([color.inverted for color in colors])
        self._stretch = self._tolerance[:, None] / [color.axes for color in colors]
        before = self._may[changed]
        for k in changed:
            self._may[k], self._whole[k] = self._reach_of(k)
        self._label_cells((before | self._may[changed]).any(axis=0).nonzero()[0])
        overlaps = bool((self._may[~self._inverted].sum(axis=0, dtype=np.uint8) > 1).any())
        if overlaps != self.overlaps:
            self.overlaps, self._survivors = overlaps, Survivors(overlaps, HAS_16_BIT_LUT)
        self.touched = np.logical_or.reduce(self._may)
        self._column_filter = None if HAS_16_BIT_LUT else ColumnFilter(self._may)
        self._gray = self.label_colors(np.repeat(np.arange(256)[:, None], 3, axis=1))
        self.holds_gray = bool(self._gray.any())

    def _reach_of(self, k: int) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """(65536,) each: which cells contain any part of a color, and which of nothing else."""
        center, radius = cell_bounds()
        samples, others, stretch = self._samples[k], self._others[k], self._stretch[k]
        squared, reach = self._tolerance[k] ** 2, (radius.T + self._tolerance[k] / stretch).T
        low, high = samples.min(axis=0)[:, None], samples.max(axis=0)[:, None]
        (near,) = ((center + reach > low) & (center - reach < high)).all(axis=0).nonzero()
        bounds = center[:, near], radius[:, near]
        nearest, farthest = distance_bounds(*bounds, samples, stretch)
        near_other, far_other = distance_bounds(*bounds, others, stretch)
        touched, whole = np.zeros((2, CELLS), bool)
        touched[near] = (nearest < squared) & (nearest < far_other)
        whole[near] = (farthest < squared) & (farthest < near_other)
        return (~whole, ~touched) if self._inverted[k] else (touched, whole)

    def _label_cells(self, cells: NDArray[np.intp]) -> None:
        """Label some cells, CUT if their colors must be looked up one by one, and forget those."""
        labels = np.zeros(len(cells), np.uint8)
        for k in range(len(self._colors)):
            touched, whole = self._may[k, cells], self._whole[k, cells]
            labels[touched] = np.where((whole & (labels == 0))[touched], k + 1, CUT)
        self._cells[cells] = labels
        known = cells[self._is_known[cells]]
        self._exact[colors_in(known)] = UNKNOWN
        self._is_known[known] = False

    def label_colors(
        self, rgb: NDArray[np.integer], may: NDArray[np.bool_] | None = None
    ) -> NDArray[np.uint8]:
        """Label colors by the definition, one by one in double precision.

        :param rgb: (N, 3) red, green, blue.
        :param may: (colors, M) whether any of M equal parts of these may be of each; None: all.
        :returns: (N,) labels.
        """
        may = np.ones((len(self._colors), 1), bool) if may is None else may
        parts = may.shape[1], len(rgb) // may.shape[1]
        lab = lab_from_rgb(rgb).reshape(*parts, 3)
        labels, smallest = np.zeros(parts, np.uint8), np.full(parts, np.inf)
        for k, tolerance in enumerate(self._tolerance):
            (near,) = may[k].nonzero()
            squared = self._squared(k, lab[near].reshape(-1, 3)).reshape(-1, parts[1])
            label, least = labels[near], smallest[near]
            if self._inverted[k]:
                label[(squared >= tolerance**2) & (label == 0)] = k + 1
            else:
                nearer = (squared < tolerance**2) & (squared < least)
                label[nearer], least[nearer] = k + 1, squared[nearer]
            labels[near], smallest[near] = label, least
        return labels.reshape(-1)

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
            self._compute(unknown)
            labels = self._exact.take(color)
        return labels - 1

    def _compute(self, colors: NDArray[np.int32]) -> None:
        """Label and cache colors and, if they are in few cells, all the others in these.

        :param colors: (N,) red << 16 | green << 8 | blue.
        """
        cells = np.flatnonzero(np.bincount(cell_of(colors), minlength=CELLS))
        is_few = len(cells) <= self._most_whole
        part = colors_in(cells) if is_few else np.unique(colors)[:, None]
        cells = cells if is_few else cell_of(part[:, 0])
        rgb = np.stack([part >> 16, part >> 8 & 255, part & 255], axis=-1).reshape(-1, 3)
        labels = self.label_colors(rgb, self._may[:, cells]).reshape(part.shape)
        self._exact[part] = labels + 1
        self._is_known[cells] = True
        if is_few:
            whole = (labels == labels[:, :1]).all(axis=1)
            self._cells[cells[whole]] = labels[whole, 0]
