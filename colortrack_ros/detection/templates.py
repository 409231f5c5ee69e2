"""Templates of objects, fitted jointly to the single blob that touching objects make."""

from dataclasses import dataclass
from dataclasses import field
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.blobs import positions

Mask = NDArray[np.float32]

MOST_PIXELS = 4000
"""Maximum number of pixels of a blob in a fit: larger blobs are averaged over squares."""

HIDDEN_COST = 0.5
"""Cost of a template pixel outside the blob, relative to that of a blob pixel in no template. A
hand may cause the former, but only an object the latter. What was covered in the last frame costs
nothing: hands stay. Assumed."""

PRIOR_COST = 1.0
"""Factor in the cost of an offset d from the expected place, PRIOR_COST / 2 side / sigma^2 ln(1 +
d^2 / sigma^2): half the pixels that the side of a square of its area sweeps per pixel. Objects keep
moving as before, or do something else (hence the long tail of a Cauchy distribution). Assumed."""

SEARCH_SIGMAS = 4.0
"""Search radius around the expected place [sigma]: with 8, unexplained pixels drew a barely visible
cup 40 px away for one frame."""

TURNS_OF_EACH = 4
"""Maximum number of times that each template is fitted to the pixels left by the others."""


@dataclass(frozen=True)
class BlobTemplate:
    """The appearance of an object when it was last seen alone.

    :param mask: (H, W) 1 for its pixels, 0 for others.
    :param reach: (2,) from its top left pixel to its centroid, u, v [px].
    :param box: (4,) u, v from its centroid to the corner of its box, width and height [px].
    :param covariance: (2, 2) of the centroid then [px^2].
    :param area: number of its pixels.
    :param covered: (H, W) 1 for its pixels that a hand, say, covered in the last frame, if known.
    :param offset: (2,) from the centroid of what was visible of it then to its own [px].
    """

    mask: Mask
    reach: Floats
    box: Floats
    covariance: Floats
    area: float
    covered: Mask | None = None
    offset: Floats = field(default_factory=lambda: np.zeros(2))

    @property
    def side(self) -> float:
        """Side of a square of its area [px]."""
        return float(np.sqrt(self.area))


@dataclass(frozen=True)
class Fit:
    """The places of K objects in a blob.

    :param center: (K, 2) [px].
    :param visible: (K,) pixels of each that are in the blob and in no other object.
    :param unexplained: pixels of the blob that are in none of them.
    :param step: side of the squares over which pixels were averaged [px].
    :param placed: the templates of the K objects, with what covers them now.
    """

    center: Floats
    visible: Floats
    unexplained: float
    step: int
    placed: list[BlobTemplate]


def mask_of(blobs: BlobTable, k: int) -> Mask:
    """The pixels of a blob as a mask of its box."""
    left, top, width, height = blobs.box[k]
    first = blobs.first_run[k]
    runs = blobs.runs.take(np.arange(first, first + blobs.run_count[k]))
    v, u = np.divmod(positions(runs), runs.stride)
    mask = np.zeros((height, width), np.float32)
    mask[v - top, u - left] = 1
    return mask


@dataclass(frozen=True)
class Look:
    """A frame in which some objects were alone.

    :param blobs, rows: M, of the frame.
    :param blob: of each object, by its number; negative if it was not alone.
    """

    blobs: BlobTable
    rows: NDArray[np.void]
    blob: dict[int, int]

    def area(self, number: int) -> int:
        """The area of an object [px], 0 if it was not alone."""
        blob = self.blob.get(number, -1)
        return int(self.blobs.area[blob]) if blob >= 0 else 0

    def template(self, number: int) -> BlobTemplate:
        """The template of an object."""
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
    """Place templates, in turns, so that they add up to a blob.

    Templates may overlap: which one is in front makes no difference to their common blob. The cost
    depends on pixels in the templates or the blob, but not in both. If that leaves an object free
    to move, it stays at its expected place.

    :param templates: of K objects.
    :param expected: (K, 2) their centers [px].
    :param sigma: (K,) standard deviation of expected, per axis [px].
    :param smear: (K, 2) displacement of each during the exposure [px]: blob pixels along it belong
        to the object, and do not attract others.
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
    placed = [board.placed(i, template) for i, template in enumerate(templates)]
    return Fit(center, step**2 * np.array(visible), step**2 * board.unexplained(), step, placed)


class _Board:
    """The picture of a blob and the masks on it, with pixels that are squares of step px.

    :ivar place: (K, 2) of the top left pixel of each mask, u, v.
    :ivar expected: (K, 2) its expected place.
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
        self._covered = [
            None if t.covered is None else _reduced(t.covered, step) for t in templates
        ]
        self._radius, self._step = radius.astype(int), step
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
        """Place a mask to subpixel accuracy where the pixels left by the others are worth most."""
        mask, radius, expected = self._masks[i], int(self._radius[i]), self.expected[i]
        left, covered = 1 - self._others(i), self._covered[i]
        worth = ((1 + HIDDEN_COST) * self._blob - HIDDEN_COST) * left
        u, v = np.round(expected).astype(int)
        height, width = mask.shape
        window = slice(v - radius, v + radius + height), slice(u - radius, u + radius + width)
        total = cv2.matchTemplate(worth[window], mask, cv2.TM_CCORR)
        if covered is not None:
            hidden = HIDDEN_COST * (left - self._blob * left)[window]
            total = total + cv2.matchTemplate(hidden, covered, cv2.TM_CCORR)
        way = np.arange(-radius, radius + 1)
        du, dv = way + (u - expected[0]), way + (v - expected[1])
        total = total - weight * np.log1p((du**2 + dv[:, None] ** 2) / sigma**2)
        row, column = divmod(int(total.argmax()), total.shape[1])
        self.place[i] = (
            u - radius + column + _between(total[row], column),
            v - radius + row + _between(total[:, column], row),
        )

    def visible(self, i: int) -> float:
        """Pixels of a mask that are in the blob and in no other mask."""
        part = self._blob * (1 - self._others(i))
        return float((part[self._under(i)] * self._masks[i]).sum())

    def placed(self, i: int, template: BlobTemplate) -> BlobTemplate:
        """A template with what covers it now; behind other masks, with what did so before."""
        under = self._under(i)
        others, before = self._others(i)[under], self._covered[i]
        covered = (1 - self._blob[under]) * (1 - others)
        if before is not None:
            covered = covered + others * before
        mask = _enlarged(np.asarray(covered * self._masks[i]), template.mask.shape, self._step)
        return replace(template, covered=mask, offset=np.zeros(2))

    def unexplained(self) -> float:
        """Pixels of the blob that are in no mask."""
        return float((self._blob * (1 - self._others(-1))).sum())

    def _under(self, i: int) -> tuple[slice, slice]:
        u, v = np.round(self.place[i]).astype(int)
        height, width = self._masks[i].shape
        return slice(v, v + height), slice(u, u + width)

    def _others(self, i: int) -> Mask:
        """Union of all masks but one, including the area that they sweep."""
        picture = np.zeros_like(self._blob)
        for j, (mask, margin) in enumerate(self._smeared):
            if j != i:
                u, v = np.round(self.place[j]).astype(int) - margin
                part = picture[v : v + mask.shape[0], u : u + mask.shape[1]]
                np.maximum(part, mask, out=part)
        return picture


def _smeared(mask: Mask, way: Floats) -> tuple[Mask, Indices]:
    """The area that a mask sweeps along a displacement [px], centered on the mask.

    :return: the swept mask, and (2,) its margins to the left and to the top [px].
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
    """Averages over squares, starting at the top left corner."""
    if step == 1:
        return mask
    height, width = mask.shape
    mask = np.pad(mask, ((0, -height % step), (0, -width % step)))
    size = mask.shape[1] // step, mask.shape[0] // step
    return np.asarray(cv2.resize(mask, size, interpolation=cv2.INTER_AREA), np.float32)


def _enlarged(mask: Mask, shape: tuple[int, ...], step: int) -> Mask:
    """The mask, (H, W), of averages over squares."""
    return mask.repeat(step, axis=0).repeat(step, axis=1)[: shape[0], : shape[1]]


def _between(values: Floats, k: int) -> float:
    """Offset of a parabola's vertex from a sampled maximum, fitted to it and its neighbors."""
    if not 0 < k < len(values) - 1:
        return 0.0
    low, top, high = values[k - 1 : k + 2].tolist()
    bend = low - 2 * top + high
    return (low - high) / 2 / bend if bend < 0 else 0.0
