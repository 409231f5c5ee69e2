"""Picks a reference color from a picture."""

from collections.abc import Callable
from collections.abc import Mapping
from dataclasses import asdict
from dataclasses import dataclass
from dataclasses import field
from dataclasses import replace
from functools import cache
from functools import partial
from typing import Any
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Frame
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.config import DetectorConfig
from colortrack_ros.detection.detector import Detector
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.extent import LARGEST_SHARE
from colortrack_ros.detection.extent import LEAST_SPREAD
from colortrack_ros.detection.extent import sample_colors
from colortrack_ros.detection.growth import MOST_GROWTH
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.own_color import own_color_at
from colortrack_ros.detection.pixels import split_rgb
from colortrack_ros.detection.reference import expect
from colortrack_ros.detection.reference import MAX_TOLERANCE
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.shape import ShapeConfig
from colortrack_ros.detection.strangers import find_own_extent
from colortrack_ros.encodings import check
from colortrack_ros.encodings import plain
from colortrack_ros.encodings import writable_bgr

SEED_REACH = 3
"""Half the side of the square whose median is the initial color [px]: 49 pixels."""

OWN_REACH = 1
"""The same where a thing shows its own color, which may be a narrow rim around a highlight [px]."""

TOLERANCES = np.arange(4.0, 81.0, 2.0)
"""Tolerances tried for a region around a point [CIELAB units]: from the least that camera noise
allows to the distance between different colors."""

STABLE_GROWTH = 0.05
"""Largest growth of a stable region between one tolerance step down and one step up, as a share of
its area. Like the other constants of this file, it is checked by test/detection/test_pick.py."""

TOLERANCE_MARGIN = 1.5
"""Ratio of the tolerance to the distance of nearly all pixels in the region: a margin for the light
of other frames."""

NEARLY_ALL = 98.0
"""Percentile of the distances, without highlights and outline pixels. Assumed: 2 % of an object."""


@dataclass(frozen=True)
class PickedColor:
    """A picked color, and what the detector finds with it in the same picture.

    :param color: with an ellipsoid, unless the detector finds that in each picture.
    :param area: expected area [px], that of the blob detected where the color was picked.
    :param share: share of the picture that the color covers.
    :param telling: limits, by parameter, that reject similarly colored objects.
    :param runs_on: whether its pixels run into those of other colors without a gap.
    """

    color: ReferenceColor
    area: int
    share: float
    telling: Mapping[str, float] = field(default_factory=dict)
    runs_on: bool = False

    @property
    def limits(self) -> dict[str, Any]:
        """Limits for the detector, by parameter; none if it finds the least area itself.

        The least area admits objects of half the size, or half hidden, but no glints.
        """
        if self.color.is_sought:
            return {}
        least = max(self.area // 4, self.telling.get('min_area', 1))
        return {**self.telling, 'min_area': least}


def pick_color(
    frame: Frame,
    u: int,
    v: int,
    name: str = 'picked',
    config: DetectorConfig | None = None,
    fixed: bool = False,
) -> PickedColor:
    """Pick the color of the object at a pixel.

    One picture does not tell how light, dark, and far away the object will be. So its color has no
    tolerance and no least area: the detector finds both in each picture. Only if it misses the
    object in this one, the color extends to where others begin (:func:`find_own_extent`), or is
    that of the maximally stable region around the pixel (Matas 2004).

    :param u, v: the pixel [px]; name: of the color.
    :param config: of the detector; its colors, sizes, and shapes are ignored.
    :param fixed: whether to give the tolerance and the least area of this picture anyway.
    :raises ValueError: if the pixel is outside the picture.
    """
    check(frame)
    frame = plain(frame)
    rows, columns = frame.image.shape[:2]
    valid = 0 <= u < columns and 0 <= v < rows
    expect(valid, 'pixel', (u, v), f'u, v in the picture of {columns} x {rows} px')
    rgb = np.stack(split_rgb(frame.image, frame.encoding), axis=-1)
    found = cache(partial(_found_at, frame, config or DetectorConfig()))
    place, extent, *_ = _clearest(frame, rgb, u, v, name, found)
    region = cache(lambda: _stable_region(rgb, u, v))  # slow, and rarely needed
    near = cache(lambda: _color_of(rgb, region(), name))
    whole = _of_extent(extent, name) if extent else near()
    tried = [(c, *found(place, c)) for c in (ReferenceColor(name, whole.lab), whole)[fixed:]]
    color, blobs, share = max(tried, key=lambda one: len(one[1].area) > 0)
    if extent and not len(blobs.area):  # beside a larger thing that its color runs into
        beside = near(), *found(place, near())
        if len(beside[1].area) and beside[2] <= LARGEST_SHARE:
            color, blobs, share = beside
    area = int(blobs.area.max(initial=0)) or int(region().sum())
    return PickedColor(color, area, share, runs_on=bool(extent and extent.growth > MOST_GROWTH))


class _Sight(NamedTuple):
    """How far the color of a place reaches, and the blobs there that the detector finds by it."""

    place: tuple[int, int]
    extent: Extent | None = None
    blobs: BlobTable | None = None

    @property
    def growth(self) -> float:
        """How much the color runs into others, infinite if nothing is found."""
        is_found = self.blobs is not None and len(self.blobs.area) > 0
        return self.extent.growth if self.extent and is_found else np.inf


def _clearest(
    frame: Frame, rgb: NDArray[np.uint8], u: int, v: int, name: str,
    found: Callable[[tuple[int, int], ReferenceColor], tuple[BlobTable, float]],
) -> _Sight:  # fmt: skip
    """The sight of the color at a pixel, or of the thing's own color if that runs into others less.

    A highlight may have the color of a pale floor, or run into it, where its own color does not.

    :param found: _found_at() of the frame.
    """
    cells, counts = sample_colors(frame.image, frame.encoding)
    seed = _seed_of(rgb, u, v)

    def sight(place: tuple[int, int], lab: Triple, fixed: bool = False) -> _Sight:
        extent, _ = find_own_extent(cells, counts, lab)
        if extent is None:
            return _Sight(place)
        whole = _of_extent(extent, name)
        color = whole if fixed else ReferenceColor(name, whole.lab)
        return _Sight(place, extent, found(place, color)[0])

    here = sight((u, v), seed)
    own = here.place if here.growth <= MOST_GROWTH else own_color_at(rgb, u, v, seed)
    if own == here.place:
        return here
    there = sight(own, _seed_of(rgb, *own, OWN_REACH))
    is_same = there.blobs is not None and boxes_hold(there.blobs, u, v).any()
    if there.growth > MOST_GROWTH and here.growth == np.inf:
        here = sight(here.place, seed, fixed=True)
    return there if is_same and there.growth < here.growth else here


def _found_at(
    frame: Frame, config: DetectorConfig, place: tuple[int, int], color: ReferenceColor
) -> tuple[BlobTable, float]:
    """The blobs at a place, and the share of the picture that a color covers.

    One picture shows nothing that moves, and what is clicked may have any size and shape.
    """
    config = replace(config, colors=(color,), moving_only=False, **asdict(ShapeConfig()))
    detector = Detector(config)
    detector.detect(frame)
    blobs = detector.blobs
    return blobs.take(are_at(blobs, *place, SEED_REACH)), float(np.mean(detector.mask > 0))


def are_at(blobs: BlobTable, u: int, v: int, reach: int = 0) -> Bools:
    """Return which blobs, (N,), have a pixel within a reach [px] of (u, v), by rows and columns."""
    row, left, right = blobs.runs.ends()
    near = (abs(row - v) <= reach) & (left <= u + reach) & (u - reach < right)
    parts = zip(blobs.first_run, blobs.run_count, strict=True)
    return np.array([near[first : first + count].any() for first, count in parts], bool)


def boxes_hold(blobs: BlobTable, u: int, v: int) -> Bools:
    """Return which blobs, (N,), have a box that contains (u, v)."""
    away = np.array([u, v]) - blobs.box[:, :2]
    return np.asarray(((away >= 0) & (away <= blobs.box[:, 2:])).all(axis=1))


def _of_extent(extent: Extent, name: str) -> ReferenceColor:
    """Convert an extent to a reference color, with rounded numbers."""
    L, a, b = (round(x, 1) for x in extent.lab)
    dL, da, db = (round(min(x, MAX_TOLERANCE), 1) for x in extent.axes)
    return ReferenceColor(name, (L, a, b), max(da, db), (dL, da, db))


def _color_of(rgb: NDArray[np.uint8], region: NDArray[np.bool_], name: str) -> ReferenceColor:
    """The median color of a region, with a tolerance that fits the spread along each axis."""
    lab = lab_from_rgb(rgb[region])
    L, a, b = np.median(lab, axis=0).round(1).tolist()
    away = np.abs(lab - (L, a, b))
    shape = np.maximum(np.percentile(away, NEARLY_ALL, axis=0), LEAST_SPREAD)
    most = np.percentile(np.linalg.norm(away / shape, axis=1), NEARLY_ALL)
    axes = np.clip(TOLERANCE_MARGIN * most * shape, TOLERANCES[0], TOLERANCES[-1])
    dL, da, db = axes.round(1).tolist()
    return ReferenceColor(name, (L, a, b), max(da, db), (dL, da, db))


def _seed_of(rgb: NDArray[np.uint8], u: int, v: int, reach: int = SEED_REACH) -> Triple:
    """The median color of the window around a pixel."""
    rows, columns = (slice(max(x - reach, 0), x + reach + 1) for x in (v, u))
    L, a, b = np.median(lab_from_rgb(rgb[rows, columns].reshape(-1, 3)), axis=0).tolist()
    return L, a, b


def _stable_region(rgb: NDArray[np.uint8], u: int, v: int) -> NDArray[np.bool_]:
    """Pixels connected to (u, v) at the first tolerance at which they hardly grow."""
    distance = np.linalg.norm(lab_from_rgb(rgb) - _seed_of(rgb, u, v), axis=-1)
    distance[v, u] = 0
    regions = [connected(distance < t, u, v) for t in TOLERANCES]
    area = np.array([np.count_nonzero(region) for region in regions], float)
    growth = (area[2:] - area[:-2]) / area[1:-1]
    # Regions smaller than the window are noise; those that fill the picture are background.
    growth[(area[1:-1] < SEED_REACH**2) | (area[1:-1] > LARGEST_SHARE * distance.size)] = np.inf
    first = np.flatnonzero(growth <= max(STABLE_GROWTH, growth.min()))[0]
    region = regions[first + 1]
    inner = cv2.erode(region.view(np.uint8), np.ones((3, 3), np.uint8)) != 0
    return inner if inner.any() else region


def connected(mask: NDArray[np.bool_], u: int, v: int) -> NDArray[np.bool_]:
    """What of a mask, (H, W), is connected to a pixel (u, v), which may be outside of the mask."""
    component = cv2.connectedComponents(mask.view(np.uint8))[1]
    return np.asarray(mask & (component == component[v, u]))


def side_by_side(frame: Frame, detector: Detector) -> NDArray[np.uint8]:
    """The picture, the mask and the blobs side by side, (H, 3 W, 3) BGR."""
    rows = detector.detect(frame).rows
    picture = writable_bgr(frame)
    blobs = picture.copy()
    for row in rows:
        left, top, width, height = (int(row[name]) for name in ('box_u', 'box_v', 'box_w', 'box_h'))
        cv2.rectangle(blobs, (left, top), (left + width - 1, top + height - 1), (255, 255, 255), 2)
        center = round(float(row['u'])), round(float(row['v']))
        cv2.drawMarker(blobs, center, (255, 255, 255), cv2.MARKER_CROSS, 9, 1)
    return np.hstack([picture, np.repeat(detector.mask[..., None], 3, axis=2), blobs])
