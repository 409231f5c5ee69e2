"""Teaches a reference color from positive and negative examples, pixels and boxes."""

from collections.abc import Sequence
from dataclasses import asdict
from dataclasses import dataclass
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.config import DetectorConfig
from colortrack_ros.detection.detector import Detector
from colortrack_ros.detection.extent import count_colors
from colortrack_ros.detection.extent import find_extent
from colortrack_ros.detection.extent import NEAR
from colortrack_ros.detection.extent import nearest_sample
from colortrack_ros.detection.extent import SHAPE
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.pick import PickedColor
from colortrack_ros.detection.pick import SEED_REACH
from colortrack_ros.detection.pixels import split_rgb
from colortrack_ros.detection.reference import expect
from colortrack_ros.detection.reference import MAX_TOLERANCE
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.reference import Triple
from colortrack_ros.detection.shape import MEASURES
from colortrack_ros.detection.shape import ShapeConfig
from colortrack_ros.encodings import check
from colortrack_ros.encodings import plain

SHADES_OF_BOX = 3
"""Shades taken from a box: its dark, middle and light third. With one or six, `python
benchmark/colors.py --constants` changes by less than a point. With one, however, the color of a
patterned box that fills the picture is not rejected."""

SHOWN_PERCENT = 80.0
"""Least share of the examples' pixels that the color covers [%]: a box has corners and highlights.
`python benchmark/colors.py --constants`: half of it changes nothing; with all of it, the color of a
pale ball becomes that of the room."""

TELLING_RATIO = 2.0
"""Least ratio of the share of negative pixels nearest to a shade, to that of positive pixels, for
the shade to be discriminative. Below, it would remove as much of the color as of the others.
Chosen."""

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

    def thing(self) -> NDArray[np.float64]:
        """(N, 3) pixels of the object in CIELAB, as far as one color covers it.

        For a box, the pixels inside. For a pixel, those connected to it in the color picked there.
        """
        shown = lab_from_rgb(self.pixels())
        frame, (u, v, _, _) = plain(self.frame), self.box
        if not self.is_pixel:
            return shown
        extent = find_extent(count_colors(frame.image, frame.encoding), _triple(self.shades()[0]))
        if extent is None:
            return shown
        lab = lab_from_rgb(np.stack(split_rgb(frame.image, frame.encoding), axis=-1))
        inside = (((lab - extent.lab) / extent.axes) ** 2).sum(axis=2) < 1
        _, part = cv2.connectedComponents(inside.view(np.uint8))
        return np.concatenate([shown, lab[inside & (part == part[v, u])]])


def teach_color(
    examples: Sequence[Example],
    others: Sequence[Example] = (),
    name: str = 'taught',
    config: DetectorConfig | None = None,
) -> PickedColor:
    """The color of the examples, which extends in all their pictures to where other colors begin.

    :param examples: positive examples, at least one.
    :param others: negative examples. Shades that are more common in the object than in them do not
        discriminate, and are ignored; negatives that still match the color are rejected by size or
        shape.
    :param config: of the detector that measures sizes and shapes; its colors, and its limits of
        sizes and shapes, are ignored.
    :raises ValueError: if an example is outside its picture, or the color fills the pictures.
    """
    samples = _distinct(examples)
    shown = np.concatenate([example.thing() for example in examples])
    not_it = _telling(_distinct(others, samples), samples, shown, others)
    frames = {id(example.frame): plain(example.frame) for example in examples}.values()
    counts = np.sum([count_colors(frame.image, frame.encoding) for frame in frames], axis=0)
    away = nearest_sample(shown, samples, SHAPE)
    mine = away < nearest_sample(shown, not_it, SHAPE)
    least = float(np.percentile(away[mine], SHOWN_PERCENT)) if mine.any() else 0.0
    extent = find_extent(counts, samples[0], samples[1:], not_it, least=least)
    if extent is None:
        raise ValueError(
            f'{name}: expected a color that ends somewhere, got one that fills the pictures: give '
            'examples of what is not it'
        )
    L, a, b = (round(min(axis, MAX_TOLERANCE), 1) for axis in extent.axes)
    color = ReferenceColor(name, samples[0], max(a, b), (L, a, b), samples[1:], not_it)
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


def _telling(
    not_it: tuple[Triple, ...],
    samples: tuple[Triple, ...],
    shown: NDArray[np.float64],
    others: Sequence[Example],
) -> tuple[Triple, ...]:
    """Select negative shades that are nearest to far more negative than positive pixels.

    The comparison is between shares of the pixels, see TELLING_RATIO.
    """
    if not not_it:
        return ()
    shades = *not_it, *samples
    them = np.concatenate([other.thing() for other in others])
    its, theirs = (
        np.bincount(
            np.argmin([nearest_sample(lab, (s,), SHAPE) for s in shades], axis=0),
            minlength=len(shades),
        )
        for lab in (shown, them)
    )
    its, theirs = (count / count.sum() for count in (its, theirs))
    return tuple(shade for k, shade in enumerate(not_it) if theirs[k] > TELLING_RATIO * its[k])


def _blob_of(detector: Detector, example: Example, exactly: bool = False) -> BlobTable:
    """The largest blob whose box contains the center of an example, or an empty table.

    :param exactly: only if the center pixel itself has the color.
    """
    detector.detect(example.frame)
    u, v, width, height = example.box
    blobs, u, v = detector.blobs, u + width // 2, v + height // 2
    away = np.array([u, v]) - blobs.box[:, :2]
    holds = ((away >= 0) & (away <= blobs.box[:, 2:])).all(axis=1)
    holds &= not exactly or detector.labels[v, u] > 0
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


def _distinct(examples: Sequence[Example], known: tuple[Triple, ...] = ()) -> tuple[Triple, ...]:
    """The shades of the examples, without those similar to each other or to a known one."""
    kept: list[Triple] = []
    for shade in (shade for example in examples for shade in example.shades()):
        if all(np.linalg.norm(shade - other) > NEAR / 2 for other in (*known, *kept)):
            kept.append(_triple(shade))
    return tuple(kept)


def _triple(lab: NDArray[np.float64]) -> Triple:
    L, a, b = lab.tolist()
    return L, a, b
