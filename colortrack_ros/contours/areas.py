"""Connected areas of a mask, split where several things touch."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.boxes import overlaps

Mask = NDArray[np.uint8]

CORE = 0.6
"""Depth of an area's cores below its outline, as a share of the deepest pixel's. IDF1 of
PETS S3.MF1 (benchmark/notes/contours.md) is 0.84; with half of this 0.81, with nothing cut 0.71
(``benchmark/real_contours.py FOLDER --constants areas.CORE``)."""

PART = 0.25
"""Least share of an area that becomes a part. Half and twice: 0.85 and 0.71 (as above)."""

FITS = 0.6
"""Intersection over union with a known target above which an area is not split. Half: 0.73; always
splitting: 0.85 (as above)."""


@dataclass(frozen=True)
class Areas(Columns):
    """K segmented areas of a frame.

    :ivar box: (K, 4) left, top, right, bottom, the first and last column and row [px].
    :ivar center: (K, 2) centroids [px].
    :ivar size: (K,) [px].
    :ivar piece: (K,) whether an area is a part of one that was split.
    :ivar cut: (K, 4) whether left, top, right, and bottom touch the border of the picture.
    :ivar mask: (K,) masks of the boxes, 1 where pixels belong to the area.
    """

    box: Floats
    center: Floats
    size: Floats
    piece: Bools
    cut: Bools
    mask: NDArray[np.object_]

    @classmethod
    def none(cls) -> 'Areas':
        """Return a table without areas."""
        no = np.zeros(0)
        box = np.zeros((0, 4))
        return cls(box, np.zeros((0, 2)), no, no > 0, box > 0, np.zeros(0, object))

    def outline(self, k: int, kind: str = 'area') -> Floats:
        """Return the outline of area k, or its box, as in Figure 2: a closed polygon, (P, 2)
        [px].
        """
        if kind == 'box':
            return self.box[k][[[0, 1], [2, 1], [2, 3], [0, 3]]]
        found, _ = cv2.findContours(self.mask[k], cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        return np.asarray(max(found, key=len)[:, 0] + self.box[k, :2], float)


def find_areas(mask: Mask, least: int, known: Floats) -> Areas:
    """Return the connected areas of a mask, with holes filled.

    :param mask: (H, W), not 0 where something is.
    :param least: smaller areas are ignored [px].
    :param known: (M, 4) predicted boxes of targets [px]: an area as large as one of them is not
        split.
    """
    if not mask.any():
        return Areas.none()
    left, top, width, height = cv2.boundingRect(mask)
    inner = mask[top : top + height, left : left + width]
    _, labels, stats, _ = cv2.connectedComponentsWithStats(inner)
    found = []
    for k in 1 + np.flatnonzero(stats[1:, cv2.CC_STAT_AREA] >= least):
        u, v, w, h, _ = stats[k].tolist()
        own = (labels[v : v + h, u : u + w] == k).astype(np.uint8)
        outer, _ = cv2.findContours(own, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        cv2.drawContours(own, outer, -1, 1, cv2.FILLED)
        box = np.array([u, v, u + w - 1, v + h - 1], float) + np.tile([left, top], 2)
        fits = overlaps(known, box[None]).max(initial=0.0) > FITS
        pieces = [own] if fits else split(own, least)
        found += [(piece, left + u, top + v, len(pieces) > 1) for piece in pieces]
    return _table(found, np.array(mask.shape[::-1]))


def _table(found: list[tuple[Mask, int, int, bool]], shape: Indices) -> Areas:
    """Return areas, given masks, their left and top, and whether each is a piece."""
    count = len(found)
    box, center, size = np.zeros((count, 4)), np.zeros((count, 2)), np.zeros(count)
    piece, masks = np.zeros(count, bool), np.empty(count, object)
    for k, (mask, left, top, is_piece) in enumerate(found):
        u, v, w, h = cv2.boundingRect(mask)
        sums = cv2.moments(mask, binaryImage=True)
        box[k] = left + u, top + v, left + u + w - 1, top + v + h - 1
        center[k] = left + sums['m10'] / sums['m00'], top + sums['m01'] / sums['m00']
        size[k], piece[k], masks[k] = sums['m00'], is_piece, mask[v : v + h, u : u + w].copy()
    cut = np.hstack([box[:, :2] <= 0, box[:, 2:] >= shape - 1])
    return Areas(box, center, size, piece, cut, masks)


def split(mask: Mask, least: int) -> list[Mask]:
    """Return an area, or its parts if it consists of several things side by side.

    Each pixel goes to the nearest core. Cores above each other, such as a head, a body, and legs,
    are one thing.
    """
    edged = cv2.copyMakeBorder(mask, 1, 1, 1, 1, cv2.BORDER_CONSTANT)
    depth = cv2.distanceTransform(edged, cv2.DIST_L2, cv2.DIST_MASK_5)[1:-1, 1:-1]
    cores = (depth > CORE * depth.max()).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(cores)
    left = stats[1:, cv2.CC_STAT_LEFT]
    group = _beside(left, left + stats[1:, cv2.CC_STAT_WIDTH])
    if group.max(initial=0) == 0:
        return [mask]
    labels = np.concatenate([[0], group + 1])[labels]
    _, nearest = cv2.distanceTransformWithLabels(1 - cores, cv2.DIST_L2, cv2.DIST_MASK_5)
    names = np.zeros(nearest.max() + 1, labels.dtype)
    names[nearest[cores > 0]] = labels[cores > 0]
    labels = names[nearest] * mask
    size = np.bincount(labels.ravel())[1:]
    large = 1 + np.flatnonzero(size >= max(PART * size.sum(), least))
    return [(labels == k).astype(np.uint8) for k in large] if len(large) > 1 else [mask]


def _beside(left: Indices, right: Indices) -> Indices:
    """Return the groups, (K,) from 0, of spans; overlapping ones are in the same group."""
    order = np.argsort(left, kind='stable')
    reach = np.maximum.accumulate(right[order])
    group = np.zeros(len(left), int)
    group[order[1:]] = np.cumsum(left[order[1:]] >= reach[:-1])
    return group
