"""Templates of things, fitted together to the one blob that they make where they touch."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.blobs import positions

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.float32]

MOST_PIXELS = 4000
"""Pixels of a blob that a fit looks at: of larger ones it looks at the means of squares."""

HIDDEN_COST = 0.5
"""What a pixel of a template costs that is not in the blob, over one of the blob that is in no
template: a hand may hide the one, nothing but a thing makes the other. Assumed."""

PRIOR_COST = 1.0
"""Cost of being off by d from where a thing is expected, over side ln(1 + d^2 / sigma^2): half the
pixels that the side of a square of its area passes over in a pixel. Things go on as they did, or
do something else (as of a Cauchy distribution, with its long tail). Assumed."""

SEARCH_SIGMAS = 4.0
"""How far from there a thing is looked for [sigma]: with 8, pixels that nothing explains drew a cup
that was hardly seen 40 px away for a frame."""

TURNS_OF_EACH = 4
"""How often each template is fitted to what the others leave, at most."""


@dataclass(frozen=True)
class BlobTemplate:
    """What a thing looked like when it was last seen alone.

    :param mask: (H, W) 1 for its pixels, 0 for others.
    :param reach: (2,) from its top left pixel to its centroid, u, v [px].
    :param box: (4,) u, v from its centroid to the corner of its box, width and height [px].
    :param covariance: (2, 2) of the centroid then [px^2].
    :param area: its pixels.
    """

    mask: Mask
    reach: Floats
    box: Floats
    covariance: Floats
    area: float

    @property
    def side(self) -> float:
        """Of a square of its area [px]."""
        return float(np.sqrt(self.area))


@dataclass(frozen=True)
class Fit:
    """Where K things are in a blob.

    :param center: (K, 2) [px].
    :param visible: (K,) pixels of each that are in the blob and in no other.
    :param unexplained: pixels of the blob that are in none of them.
    :param step: side of the squares that were looked at [px].
    """

    center: Floats
    visible: Floats
    unexplained: float
    step: int


def mask_of(blobs: BlobTable, k: int) -> Mask:
    """The pixels of a blob, in its box."""
    left, top, width, height = blobs.box[k]
    first = blobs.first_run[k]
    runs = blobs.runs.take(np.arange(first, first + blobs.run_count[k]))
    v, u = np.divmod(positions(runs), runs.stride)
    mask = np.zeros((height, width), np.float32)
    mask[v - top, u - left] = 1
    return mask


@dataclass(frozen=True)
class Look:
    """A frame in which some things were alone.

    :param blobs, rows: M, of the frame.
    :param blob: of each thing, by its number; negative if it was not alone.
    """

    blobs: BlobTable
    rows: NDArray[np.void]
    blob: dict[int, int]

    def area(self, number: int) -> int:
        """That of a thing [px], 0 if it was not alone."""
        blob = self.blob.get(number, -1)
        return int(self.blobs.area[blob]) if blob >= 0 else 0

    def template(self, number: int) -> BlobTemplate:
        """What a thing looked like."""
        blobs, blob = self.blobs, self.blob[number]
        row = self.rows[blob]
        covariance = np.array([row['cov_uu'], row['cov_uv'], row['cov_uv'], row['cov_vv']])
        corner = row['box_u'] - row['u'], row['box_v'] - row['v']
        return BlobTemplate(
            mask_of(blobs, blob),
            blobs.mean[blob] - blobs.box[blob, :2],
            np.array([*corner, row['box_w'], row['box_h']]),
            covariance.reshape(2, 2),
            float(blobs.area[blob]),
        )


def fit_templates(
    blobs: BlobTable,
    k: int,
    templates: list[BlobTemplate],
    expected: Floats,
    sigma: Floats,
    smear: Floats,
) -> Fit:
    """Place templates so that together they are a blob, in turns.

    They may cover each other: which is in front does not matter for the blob that both make. What
    counts are the pixels that are in one, but not in the other; where that leaves a thing free to
    move, it stays where it is expected.

    :param templates: of K things.
    :param expected: (K, 2) their centers [px].
    :param sigma: (K,) standard deviation of those, on an axis [px].
    :param smear: (K, 2) way of each during the exposure [px]: what is in the blob along it is the
        thing's, and draws no other.
    """
    step = int(np.ceil(np.sqrt(blobs.area[k] / MOST_PIXELS)))
    radius = np.ceil(SEARCH_SIGMAS * sigma / step)
    board = _Board(blobs, k, templates, expected, radius, smear, step)
    weight = [
        PRIOR_COST / 2 * template.side / step * (step / s) ** 2
        for template, s in zip(templates, sigma, strict=True)
    ]
    for _ in range(TURNS_OF_EACH):
        before = board.place.copy()
        for i in range(len(templates)):
            board.place_best(i, weight[i], sigma[i] / step)
        if np.abs(board.place - before).max() < 0.5:
            break
    center = expected + step * (board.place - board.expected)
    visible = [board.visible(i) for i in range(len(templates))]
    return Fit(center, step**2 * np.array(visible), step**2 * board.unexplained(), step)


class _Board:
    """The picture of a blob and of the masks on it, of which a pixel is a square of step px.

    :ivar place: (K, 2) of the top left pixel of each mask, u, v.
    :ivar expected: (K, 2) where those are expected.
    """

    def __init__(
        self,
        blobs: BlobTable,
        k: int,
        templates: list[BlobTemplate],
        expected: Floats,
        radius: Floats,
        smear: Floats,
        step: int,
    ) -> None:
        self._masks = [_reduced(template.mask, step) for template in templates]
        self._radius = radius.astype(int)
        self._smeared = [
            _smeared(mask, way) for mask, way in zip(self._masks, smear / step, strict=True)
        ]
        corner = expected - [template.reach for template in templates]
        size = np.array([mask.shape[::-1] for mask in self._masks])
        aside = step * (radius[:, None] + 3) + np.abs(smear) / 2
        start, blob = blobs.box[k, :2], mask_of(blobs, k)
        low = np.floor(np.minimum((corner - aside).min(axis=0), start)).astype(int)
        high = np.maximum((corner + step * size + aside).max(axis=0), start + blob.shape[::-1])
        width, height = np.ceil(high).astype(int) - low
        picture = np.zeros((height, width), np.float32)
        u, v = start - low
        picture[v : v + blob.shape[0], u : u + blob.shape[1]] = blob
        self._blob = _reduced(picture, step)
        self.expected = (corner - low) / step
        self.place = self.expected.copy()

    def place_best(self, i: int, weight: float, sigma: float) -> None:
        """Place a mask where the pixels that no other has are worth most, between whole pixels."""
        mask, radius, expected = self._masks[i], int(self._radius[i]), self.expected[i]
        worth = ((1 + HIDDEN_COST) * self._blob - HIDDEN_COST) * (1 - self._others(i))
        u, v = np.round(expected).astype(int)
        height, width = mask.shape
        window = worth[v - radius : v + radius + height, u - radius : u + radius + width]
        total = cv2.matchTemplate(window, mask, cv2.TM_CCORR)
        way = np.arange(-radius, radius + 1)
        du, dv = way + (u - expected[0]), way + (v - expected[1])
        total = total - weight * np.log1p((du**2 + dv[:, None] ** 2) / sigma**2)
        row, column = divmod(int(total.argmax()), total.shape[1])
        self.place[i] = (
            u - radius + column + _between(total[row], column),
            v - radius + row + _between(total[:, column], row),
        )

    def visible(self, i: int) -> float:
        """What of a mask is in the blob and in no other mask."""
        part = self._blob * (1 - self._others(i))
        return float((part[self._under(i)] * self._masks[i]).sum())

    def unexplained(self) -> float:
        """What of the blob is in no mask."""
        return float((self._blob * (1 - self._others(-1))).sum())

    def _under(self, i: int) -> tuple[slice, slice]:
        u, v = np.round(self.place[i]).astype(int)
        height, width = self._masks[i].shape
        return slice(v, v + height), slice(u, u + width)

    def _others(self, i: int) -> Mask:
        """What is in any mask but one, or passed by it."""
        picture = np.zeros_like(self._blob)
        for j, (mask, margin) in enumerate(self._smeared):
            if j != i:
                u, v = np.round(self.place[j]).astype(int) - margin
                part = picture[v : v + mask.shape[0], u : u + mask.shape[1]]
                np.maximum(part, mask, out=part)
        return picture


def _smeared(mask: Mask, way: Floats) -> tuple[Mask, Indices]:
    """A mask and all that it passes on a way [px], half of it before and half behind.

    :return: the mask, and (2,) how much farther it reaches to the left and to the top [px].
    """
    margin = np.ceil(np.abs(way) / 2).astype(np.intp)
    du, dv = margin.tolist()
    if not du + dv:
        return mask, margin
    line = np.zeros((2 * dv + 1, 2 * du + 1), np.uint8)
    start, end = (np.round(margin + half).astype(int).tolist() for half in (-way / 2, way / 2))
    cv2.line(line, start, end, 1)
    return np.asarray(cv2.dilate(np.pad(mask, ((dv, dv), (du, du))), line), np.float32), margin


def _reduced(mask: Mask, step: int) -> Mask:
    """The means of squares, from the top left corner on."""
    if step == 1:
        return mask
    height, width = mask.shape
    mask = np.pad(mask, ((0, -height % step), (0, -width % step)))
    size = mask.shape[1] // step, mask.shape[0] // step
    return np.asarray(cv2.resize(mask, size, interpolation=cv2.INTER_AREA), np.float32)


def _between(values: Floats, k: int) -> float:
    """Where the parabola through a maximum and its neighbors has its own, from the maximum."""
    if not 0 < k < len(values) - 1:
        return 0.0
    low, top, high = values[k - 1 : k + 2].tolist()
    bend = low - 2 * top + high
    return (low - high) / 2 / bend if bend < 0 else 0.0
