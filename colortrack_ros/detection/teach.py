"""Teaches a reference color from positive and negative examples, pixels and boxes."""

from collections.abc import Sequence
from dataclasses import asdict
from dataclasses import dataclass
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Frame
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.cells import cell_bounds
from colortrack_ros.detection.cells import cells_of
from colortrack_ros.detection.color_table import look_up
from colortrack_ros.detection.config import DetectorConfig
from colortrack_ros.detection.detector import Detector
from colortrack_ros.detection.discriminate import discriminate
from colortrack_ros.detection.discriminate import Part
from colortrack_ros.detection.discriminate import SHAPE_OF_SHADES
from colortrack_ros.detection.extent import count_colors
from colortrack_ros.detection.extent import find_extent
from colortrack_ros.detection.extent import LARGEST_GROUND
from colortrack_ros.detection.extent import LARGEST_SHARE
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.pick import are_at
from colortrack_ros.detection.pick import boxes_hold
from colortrack_ros.detection.pick import connected
from colortrack_ros.detection.pick import pick_color
from colortrack_ros.detection.pick import PickedColor
from colortrack_ros.detection.pick import SEED_REACH
from colortrack_ros.detection.pixels import split_rgb
from colortrack_ros.detection.reference import expect
from colortrack_ros.detection.reference import MAX_TOLERANCE
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.shape import MEASURES
from colortrack_ros.detection.shape import ShapeConfig
from colortrack_ros.encodings import check
from colortrack_ros.encodings import plain

SHADES_OF_BOX = 3
"""Shades of a box that are shown: its dark, middle and light third."""

LEAST_RATIO = 1.4
"""Least ratio of sizes or shapes that discriminates between positives and negatives: a limit
halfway between is then 20 % off each, a margin for other views. Chosen."""


@dataclass(frozen=True)
class Example:
    """An object, or background, in a picture.

    :param frame: the picture.
    :param box: u, v, width, height [px]; width and height 1 for a pixel and its neighborhood.
    """

    frame: Frame
    box: tuple[int, int, int, int]

    def pixels(self) -> NDArray[np.uint8]:
        """(N, 3) RGB of its pixels.

        :raises ValueError: if it is outside the picture.
        """
        check(self.frame)
        frame = plain(self.frame)
        rows, columns = frame.image.shape[:2]
        u, v, width, height = self.box
        valid = width >= 1 and height >= 1 and 0 <= u <= columns - width and 0 <= v <= rows - height
        given = f'u, v, width, height in the picture of {columns} x {rows} px'
        expect(valid, 'box', self.box, given)
        reach = SEED_REACH if self.is_pixel else 0
        part = frame.image[max(v - reach, 0) : v + height + reach]
        part = part[:, max(u - reach, 0) : u + width + reach]
        return np.stack(split_rgb(part, frame.encoding), axis=-1).reshape(-1, 3)

    @property
    def is_pixel(self) -> bool:
        """Whether it is a pixel with its neighborhood, which has a single shade."""
        return self.box[2:] == (1, 1)

    def shades(self) -> NDArray[np.float64]:
        """(N, 3) its shades in CIELAB, each of them a color that a pixel can have.

        :raises ValueError: if it is outside its picture.
        """
        rgb = self.pixels()
        order = np.argsort(lab_from_rgb(rgb)[:, 0])
        parts = np.array_split(order, 1 if self.is_pixel else SHADES_OF_BOX)
        medians = [np.median(rgb[part], axis=0) for part in parts if len(part)]
        return lab_from_rgb(np.rint(medians).astype(np.intp))

    def part(self, largest_share: float = LARGEST_SHARE, alone: bool = False) -> Part:
        """The object in its picture, as far as one color covers it.

        For a box, the ellipse inside. For a pixel, what is connected to it in the color there.

        :param largest_share: largest share of the picture that the color may cover.
        :param alone: whether no other example shows more of its shades: then it is all that the
            detector finds by its color.
        :raises ValueError: if it is outside its picture.
        """
        self.pixels()
        frame, (u, v, width, height) = plain(self.frame), self.box
        cells = cells_of(np.ascontiguousarray(frame.image), frame.encoding)
        mask = np.zeros(cells.shape, np.uint8)
        window = slice(v, v + height), slice(u, u + width)
        if self.is_pixel:
            window = _around(v), _around(u)
            counts = count_colors(frame.image, frame.encoding)
            extent = find_extent(counts, _triple(self.shades()[0]), largest_share=largest_share)
            if extent is not None:
                away = (cell_bounds()[0].T - extent.lab) / extent.axes
                look_up(((away**2).sum(axis=1) < 1).view(np.uint8), cells, mask)
                mask &= connected(mask > 0, u, v)
            if alone:
                mask |= self._found(frame)
            mask[window] = 1
        else:
            row, column = np.ogrid[:height, :width]
            row, column = (2 * row - height + 1) / height, (2 * column - width + 1) / width
            mask[window] = row**2 + column**2 <= 1
        left, top, width, height = cv2.boundingRect(mask)
        part = slice(top, top + height), slice(left, left + width)
        return Part(mask[part], cells[part], cells[window].reshape(-1), self.is_pixel)

    def _found(self, frame: Frame) -> Bools:
        """(H, W) where the detector finds it by one click; nowhere if its color has no end."""
        u, v = self.box[:2]
        picked = pick_color(frame, u, v)
        detector = Detector(DetectorConfig(colors=(picked.color,)))
        detector.detect(frame)
        found = connected(detector.labels > 0, u, v)
        ends = not picked.runs_on and found.mean() < LARGEST_SHARE
        return found if ends else np.zeros_like(found)


def _around(place: int) -> slice:
    """The window around a click, along one axis."""
    return slice(max(place - SEED_REACH, 0), place + SEED_REACH + 1)


def teach_color(
    examples: Sequence[Example],
    others: Sequence[Example] = (),
    name: str = 'taught',
    config: DetectorConfig | None = None,
) -> PickedColor:
    """The color of the examples, which extends in all their pictures to where other colors begin.

    :param examples: positive examples, at least one.
    :param others: negative examples. Shades that the object has, too, stay its own if it would fall
        to pieces without them; negatives that still match the color are rejected by size or shape.
    :param config: of the detector that measures sizes and shapes; its colors, and its limits of
        sizes and shapes, are ignored.
    :raises ValueError: if an example is outside its picture, or the color fills the pictures.
    """
    parts = [example.part(alone=len(examples) == 1) for example in examples]
    found = discriminate(parts, [other.part(LARGEST_GROUND) for other in others])
    frames = {id(example.frame): plain(example.frame) for example in (*examples, *others)}
    counts = np.sum([count_colors(f.image, f.encoding) for f in frames.values()], axis=0)
    reach = found.reach(counts)
    if reach is None:
        raise ValueError(
            f'{name}: expected a color that ends somewhere, got one that fills the pictures: give '
            'examples of what is not it'
        )
    L, a, b = (round(float(min(axis, MAX_TOLERANCE)), 1) for axis in reach * SHAPE_OF_SHADES)
    first, *samples = map(_triple, found.samples)
    not_it = tuple(map(_triple, found.others_within(reach)))
    color = ReferenceColor(name, first, max(a, b), (L, a, b), tuple(samples), not_it)
    return _measured(color, examples, others, config or DetectorConfig())


def _measured(
    color: ReferenceColor,
    examples: Sequence[Example],
    others: Sequence[Example],
    config: DetectorConfig,
) -> PickedColor:
    """Run the detector with a color, without limits of sizes and shapes."""
    detector = Detector(replace(config, colors=(color,), **asdict(ShapeConfig())))
    seen, shares = [], []
    for example in examples:
        seen.append(_blob_of(detector, example))
        shares.append(np.mean(detector.labels > 0))
    found = [int(blob.area[0]) for blob in seen if len(blob.area)]
    limits = _limits_between(seen, [_blob_of(detector, other, exactly=True) for other in others])
    return PickedColor(color, min(found, default=0), float(np.mean(shares)), limits)


def _blob_of(detector: Detector, example: Example, exactly: bool = False) -> BlobTable:
    """The blob at the center of an example, or else the largest whose box contains it.

    It is empty if there is none. (The water around a fish may match as well: its box contains all.)

    :param exactly: only if the center pixel itself has the color.
    """
    detector.detect(example.frame)
    u, v, width, height = example.box
    blobs, u, v = detector.blobs, u + width // 2, v + height // 2
    holds = are_at(blobs, u, v)
    if not exactly and not holds.any():
        holds = boxes_hold(blobs, u, v)
    return blobs.take(holds & (holds.cumsum() == 1))


def _limits_between(mine: list[BlobTable], theirs: list[BlobTable]) -> dict[str, float]:
    """Limits, by parameter, in the middle of the gaps between sizes, or between shapes.

    Each negative is rejected by the measure that differs most.

    :param mine, theirs: positives, and negatives that match the color, at most one blob in each.
    """
    mine, theirs = ([b for b in blobs if len(b.area)] for blobs in (mine, theirs))
    if not mine:
        return {}
    measures = {**MEASURES, 'min_area': _side, 'max_area': lambda blobs: 1 / _side(blobs)}
    least = {name: min(float(measure(b)[0]) for b in mine) for name, measure in measures.items()}
    limits: dict[str, float] = {}
    for blob in theirs:
        ratio = {name: least[name] / float(measures[name](blob)[0]) for name in measures}
        name = max(ratio, key=ratio.__getitem__)
        if ratio[name] >= LEAST_RATIO:
            limits[name] = max(limits.get(name, 0.0), least[name] / np.sqrt(ratio[name]))
    for name in limits:
        area = limits[name] ** (2 if name == 'min_area' else -2)
        limits[name] = round(area) if name.endswith('area') else round(float(limits[name]), 2)
    return limits


def _side(blobs: BlobTable) -> NDArray[np.float64]:
    """(N,) side of a square of equal area, which compares like shapes do [px]."""
    return np.sqrt(blobs.area)


def _triple(lab: NDArray[np.float64]) -> Triple:
    L, a, b = lab.tolist()
    return L, a, b
