"""Assignment of foreground areas to predicted contours."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from colortrack_ros.columns import Columns
from colortrack_ros.contours.areas import Areas
from colortrack_ros.contours.areas import PART
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.boxes import extents
from colortrack_ros.estimation.boxes import intersections
from colortrack_ros.estimation.records import Records

LEAST_OVERLAP = 0.1
"""Least intersection over union of the boxes of an area and its target.
Assumed: half and twice the value make 0.43 and 0.41 of an IDF1 of 0.40 on TUD Campus,
and change nothing on PETS S3.MF1 (``benchmark/real_contours.py FOLDER --constants
regions.LEAST_OVERLAP``)."""

MOST_OF = 0.5
"""An area, or a target, belongs to whatever covers more than this share of its box. IDF1 of
PETS S3.MF1 (benchmark/notes/contours.md) is 0.84; with half of this 0.71, with no such areas 0.83
(``benchmark/real_contours.py FOLDER --constants regions.MOST_OF``)."""

SIDE_BY_SIDE = 0.25
"""Things side by side share at most this part of the narrower one's columns: arms, and striding
legs. Assumed; half and twice the value change nothing on S3.MF1 (as above)."""

APART_SECONDS = 1.0
"""What would get away from another one by its own size within this time does not move with it [s]:
people whom a bus passes. With 0.25 s MOTA of S2.L1 b then is 0.87, not 0.93, but precision of
KITTI-17 backwards 0.73, not 0.62 (benchmark/notes/contours.md)."""

SLACK, SLACK_SHARE = 3.0, 0.1
"""Sides of a contour and of its foreground agree within this many px plus this share of the size.
It matters: IDF1 is 0.76 and 0.61 with half and twice the first, 0.74 and 0.62 with half and twice
the second (as above)."""


@dataclass(frozen=True)
class OwnAreas(Columns):
    """Foreground areas of N targets.

    :ivar box: (N, 4) around its areas [px], NaN if it has none.
    :ivar shared: (N,) whether another target is in the same area.
    :ivar cut: (N, 4) which sides of the box are at the border of the picture.
    :ivar first: (N,) index of its main area, -1 if it has none.
    :ivar piece: (N,) whether that is a part of an area that was split.
    """

    box: Floats
    shared: Bools
    cut: Bools
    first: Indices
    piece: Bools


def match(own: Floats, areas: Areas) -> tuple[OwnAreas, Bools]:
    """Assign areas to targets with boxes `own`, (N, 4) [px].

    An area goes to the target whose box it overlaps best, along with smaller areas inside that box,
    as parts of the same thing. Targets covered by another target's area share it.

    :return: the targets' areas, and which of the K areas are unassigned, (K,).
    """
    count, others = len(own), len(areas)
    first, mine = np.full(count, -1), np.zeros((count, others), bool)
    if not count or not others:
        no = np.zeros((count, 4), bool)
        none = np.full((count, 4), np.nan)
        return OwnAreas(none, no[:, 0], no, first, no[:, 0]), np.ones(others, bool)
    common = intersections(own, areas.box)
    of_own, of_area = common / extents(own)[:, None], common / extents(areas.box)
    overlap = common / (extents(own)[:, None] + extents(areas.box) - common)
    row, column = linear_sum_assignment(-np.where(overlap >= LEAST_OVERLAP, overlap, 0.0))
    good = overlap[row, column] >= LEAST_OVERLAP
    first[row[good]] = column[good]
    cover = of_own.argmax(axis=1)
    joins = (first < 0) & (of_own.max(axis=1) > MOST_OF) & np.isin(cover, column[good])
    first[joins] = cover[joins]
    has = np.flatnonzero(first >= 0)
    mine[has, first[has]] = True
    taken, holder = np.asarray(mine.any(axis=0)), of_area.argmax(axis=0)
    part = ~taken & ~areas.piece & (of_area.max(axis=0) > MOST_OF)
    part = part & _above_or_below(areas.box, first[holder])
    mine[holder[part], part] = True
    low = np.where(mine[..., None], areas.box[:, :2], np.inf).min(axis=1)
    high = np.where(mine[..., None], areas.box[:, 2:], -np.inf).max(axis=1)
    owns: Bools = np.asarray(mine.any(axis=1))
    box = np.where(owns[:, None], np.concatenate([low, high], axis=1), np.nan)
    first = np.where((first < 0) & owns, mine.argmax(axis=1), first)
    users = np.bincount(first[first >= 0], minlength=others)
    shared: Bools = np.asarray((first >= 0) & (users[first] > 1))
    box[shared] = areas.box[first[shared]]
    cut = np.asarray((mine[..., None] & areas.cut).any(axis=1))
    return OwnAreas(box, shared, cut, first, owns & areas.piece[first]), ~(taken | part)


def _above_or_below(box: Floats, main: Indices) -> Bools:
    """Return which boxes, (K, 4), share columns with others, main (K,); -1 counts as shared."""
    other = box[main]
    common = np.minimum(box[:, 2], other[:, 2]) - np.maximum(box[:, 0], other[:, 0])
    return np.asarray((main < 0) | (common >= 0))


def slack(box: Floats) -> Floats:
    """Return the tolerance, (N, 4) [px], of the sides of boxes, (N, 4)."""
    return np.tile(SLACK + SLACK_SHARE * (box[:, 2:] - box[:, :2]), 2)


def is_same(box: Floats, regions: OwnAreas) -> Bools:
    """Return which boxes, (N, 4), match a foreground of their own, within the slack."""
    return _fits(box, regions) & ~regions.shared


def _fits(box: Floats, regions: OwnAreas) -> Bools:
    """Return which boxes, (N, 4), match their foreground, shared or not, within the slack."""
    return np.asarray((np.abs(regions.box - box) <= slack(box)).all(axis=1))


def is_within(box: Floats, others: Floats) -> Bools:
    """Return which boxes, (K, 4), lie mostly inside one of others, (N, 4)."""
    common = intersections(others, box) / extents(box)
    return np.asarray(common.max(axis=0, initial=0.0) > MOST_OF)


def is_double(own: Floats, regions: OwnAreas, records: Records, velocity: Floats) -> Bools:
    """Return which targets are parts of another one, (N,).

    Either they started inside it, and their common area is as large as the other one alone: the
    rest of something that came out from behind a bar. Or they are above or below a larger one in
    its area, like legs, and were never seen separately: parts of a thing that started in pieces. So
    are those less than PART of its size that move with it, like a foot, also if they were seen
    separately; not if they were told, or are as large as the area: then the larger one is beside
    its place.

    :param own: (N, 4) boxes of the predicted targets [px].
    :param records: (N,) with CONTOUR_FIELDS.
    :param velocity: (N, 2) [px/s].
    """
    inner, single = records['inner'], records['single']
    fits = _fits(own, regions) & regions.shared
    rest = regions.shared & inner & np.isin(regions.first, regions.first[fits & ~inner])
    apart = np.hypot(*(velocity[:, None] - velocity).T).T * APART_SECONDS
    piece = _are_stacked(own, regions, PART) & (apart <= np.sqrt(extents(own))[:, None])
    piece = piece.any(axis=1) & ~fits & ~records['told']
    return np.asarray(rest | piece | ~single & _are_stacked(own, regions, 1.0).any(axis=1))


def is_piece(own: Floats, regions: OwnAreas) -> Bools:
    """Return which targets are less than PART of one above or below them in the same area, (N,).

    They may be parts of it, or pass it: what moves with it, is_double ends.

    :param own: (N, 4) boxes of the predicted targets [px].
    """
    fits = _fits(own, regions) & regions.shared
    return np.asarray(_are_stacked(own, regions, PART).any(axis=1) & ~fits)


def _are_stacked(own: Floats, regions: OwnAreas, share: float) -> Bools:
    """Return which targets are above or below which other one in the same area, (N, N), and less
    than this share of its size.
    """
    together = regions.shared[:, None] & (regions.first[:, None] == regions.first)
    size = extents(own)
    smaller = size[:, None] < share * size
    return np.asarray((_in_common(own[:, ::2]) > SIDE_BY_SIDE) & together & smaller)


def _in_common(span: Floats) -> Floats:
    """Return the overlaps, (N, N), of spans, (N, 2), in units of the shorter one's length."""
    common = np.minimum(span[:, None, 1], span[:, 1]) - np.maximum(span[:, None, 0], span[:, 0])
    length = np.maximum(span[:, 1] - span[:, 0], 1.0)
    return np.asarray(common / np.minimum(length[:, None], length))


def is_hidden(own: Floats, regions: OwnAreas) -> Bools:
    """Return which targets are hidden, (N,): the area they share is that of another one alone.

    They are behind it, or a second contour of it, and end like unseen targets.

    :param own: (N, 4) boxes of the predicted targets [px].
    """
    fits = _fits(own, regions) & regions.shared
    hidden = regions.shared & np.isin(regions.first, regions.first[fits])
    off = np.abs(regions.box - own).sum(axis=1)
    for k in np.unique(regions.first[fits]):
        rows = np.flatnonzero(fits & (regions.first == k))
        hidden[rows[np.argmin(off[rows])]] = False
    return np.asarray(hidden)


def shifts(own: Floats, region: Floats, cut: Bools) -> Floats:
    """Return the shifts, (N, 2) [px], from boxes `own`, (N, 4), to their regions.

    The mean shift of both sides, or, if the size differs, that of the side nearer to its
    prediction: whatever covers a part of a target, or joins it, leaves the other side alone. Sides
    at the border of the picture do not count.

    :param region: (N, 4) boxes [px].
    :param cut: (N, 4) which of their sides are at the border.
    """
    off = region - own
    low, high = off[:, :2], off[:, 2:]
    nearer = np.where(np.abs(low) < np.abs(high), low, high)
    shift = np.where(np.abs(high - low) > slack(own)[:, :2], nearer, (low + high) / 2)
    shift = np.where(cut[:, :2] & ~cut[:, 2:], high, shift)
    return np.asarray(np.where(cut[:, 2:] & ~cut[:, :2], low, shift))


def in_common(own: Floats, region: Floats, group: Indices) -> Floats:
    """Return shifts, (N, 2) [px], of targets that share a region, by their outermost sides.

    :param own: (N, 4) boxes of the targets [px].
    :param region: (N, 4) boxes of what they share [px].
    :param group: (N,) equal for targets that share a region.
    """
    off, result = region - own, np.zeros((len(own), 2))
    for k in np.unique(group):
        rows = np.flatnonzero(group == k)
        low, high = own[rows, :2], own[rows, 2:]
        near = (high - low) / 4
        first, last = low <= low.min(axis=0) + near, high >= high.max(axis=0) - near
        a, b = off[rows, :2], off[rows, 2:]
        either = np.where(np.abs(a) < np.abs(b), a, b)
        result[rows] = np.where(first & last, either, np.where(first, a, np.where(last, b, 0.0)))
    return result


def resized(nodes: Floats, own: Floats, box: Floats) -> Floats:
    """Return nodes, (N, n, 2), after stretching their boxes, `own`, to `box`, (N, 4) each."""
    scale = (box[:, 2:] - box[:, :2]) / np.maximum(own[:, 2:] - own[:, :2], 1.0)
    return np.asarray(box[:, None, :2] + (nodes - own[:, None, :2]) * scale[:, None])
