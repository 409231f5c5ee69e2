"""Areas of a mask: each for itself, and cut where several things touch."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.boxes import Floats
from colortrack_ros.contours.boxes import overlaps
from colortrack_ros.data import Columns

Bools = NDArray[np.bool_]
Mask = NDArray[np.uint8]

CORE = 0.6
"""The cores of an area are farther from its outline than this share of the farthest pixel. IDF1 of
PETS S3.MF1 (benchmark/notes/contours.md) is 0.84; with half of this 0.81, with nothing cut 0.71
(``benchmark/real_contours.py FOLDER --constants areas.CORE``)."""

PART = 0.25
"""Least share of an area that is a thing of its own. Half and twice: 0.85 and 0.71 (as above)."""

FITS = 0.6
"""Intersection over union of an area and a target that is known, above which it is not cut.
Half: 0.73; without it, always cutting: 0.85 (as above)."""


@dataclass(frozen=True)
class Areas(Columns):
    """K segmented areas of a frame.

    :ivar box: (K, 4) first and last column and row of each: left, top, right, bottom [px].
    :ivar center: (K, 2) their centroids [px].
    :ivar size: (K,) [px].
    :ivar piece: (K,) whether an area is a part of one that was cut.
    :ivar cut: (K, 4) whether left, top, right and bottom are those of the picture.
    :ivar mask: (K,) of each the pixels in its box, 1 where they are its own.
    """

    box: Floats
    center: Floats
    size: Floats
    piece: Bools
    cut: Bools
    mask: NDArray[np.object_]

    @classmethod
    def none(cls) -> 'Areas':
        """No areas."""
        no = np.zeros(0)
        box = np.zeros((0, 4))
        return cls(box, np.zeros((0, 2)), no, no > 0, box > 0, np.zeros(0, object))

    def outline(self, k: int, kind: str = 'area') -> Floats:
        """The outline of one of them, or as in Figure 2 its box: a closed polygon (P, 2) [px]."""
        if kind == 'box':
            return self.box[k][[[0, 1], [2, 1], [2, 3], [0, 3]]]
        found, _ = cv2.findContours(self.mask[k], cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        return np.asarray(max(found, key=len)[:, 0] + self.box[k, :2], float)


def find_areas(mask: Mask, least: int, known: Floats) -> Areas:
    """The connected areas of a mask, their holes filled.

    :param mask: (H, W), not 0 where something is.
    :param least: smaller ones are none [px].
    :param known: (M, 4) boxes of targets where they are expected [px]: what is as large as one of
        them is not cut.
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


def _table(found: list[tuple[Mask, int, int, bool]], shape: NDArray[np.intp]) -> Areas:
    """Areas of masks, with their left and top, and whether each is a piece."""
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
    """An area, or its parts where it is two or more things side by side: cut at its necks.

    Each pixel belongs to the nearest core. What is above each other, as a head, a body and legs,
    is one thing.
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


def _beside(left: NDArray[np.intp], right: NDArray[np.intp]) -> NDArray[np.intp]:
    """Groups of spans, (K,) from 0: those that overlap are in one."""
    order = np.argsort(left, kind='stable')
    reach = np.maximum.accumulate(right[order])
    group = np.zeros(len(left), int)
    group[order[1:]] = np.cumsum(left[order[1:]] >= reach[:-1])
    return group
