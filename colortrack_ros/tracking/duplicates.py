"""Duplicates: several detections of one object in the same frame, as of a detector without NMS.

Two objects hardly ever have nearly the same box, and never for long. So of boxes that coincide, as
many are kept as there are confirmed tracks that take them, and one where there is none. Points
coincide that are no further apart than two measurements of one object: a second object that near is
found once it is further away, as it is by chance every few frames unless both are at one place. In
a crowd, points come that near, too: they are left out only where the detector finds things twice.
"""

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Indices
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.gaussian import invert
from colortrack_ros.tracking.doubts import LIKELY_TURNED
from colortrack_ros.tracking.hypotheses import Association
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.overlaps import Overlaps
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.rectangles import points_inside

SAME_OBJECT = 0.7
"""Intersection over union above which two boxes are of one object: that above which Faster R-CNN
suppresses one (Ren et al. 2015, 3.3). With 0.5, all duplicates of boxes of 40 px whose sides err by
3 px are found, but people side by side in public detections lose 2 points of IDF1."""

TWO_OF_ONE = 2 * 9.21
"""Squared distance of two measurements of one object, over the covariance of one, that 1 % of them
exceed (chi-square, two degrees of freedom): their difference has twice that covariance."""

MOST_COINCIDENT = 16
"""Boxes compared with each where there are many, to bound the time. Assumed."""


def leave_out_duplicates(
    prediction: Prediction, blobs: Measurements, associated: Association, overlaps: Overlaps
) -> tuple[Association, Measurements]:
    """Return the association and the blobs without duplicates, which start and confirm nothing.

    :param overlaps: whether the detector finds things twice; updated here.
    """
    duplicate = _find(prediction, blobs, associated, twice=overlaps.find_twice)
    count = int(np.count_nonzero(duplicate))
    overlaps.count_duplicates(count, len(blobs))
    if not (count and (prediction.sized or overlaps.find_twice)):
        return associated, blobs
    pairs, probability, free, hard = associated
    kept = (~duplicate[pairs.blob]).nonzero()[0]
    free = free & ~duplicate
    return Association(pairs.take(kept), probability[kept], free, hard), blobs.take(~duplicate)


def leave_out_points(
    prediction: Prediction, blobs: Measurements, associated: Association, overlaps: Overlaps
) -> Association:
    """Return the association without duplicates, where no detection has a box.

    It comes last: what is near somebody may be the stray of another.
    """
    records, pairs = prediction.records, associated.pairs
    # whether each is taken by somebody who is confirmed
    sure = len(pairs) == len(records) == len(blobs) == np.count_nonzero(records['state'])
    if sure and not (overlaps.find_twice and np.count_nonzero(_has_turned(pairs))):
        return associated
    return leave_out_duplicates(prediction, blobs, associated, overlaps)[0]


def _has_turned(pairs: Hypotheses) -> Bools:
    """(K,) which tracks have more likely turned than not, if the blobs are theirs."""
    return np.asarray(pairs.innovations.maneuvered > LIKELY_TURNED)


def _find(
    prediction: Prediction, blobs: Measurements, associated: Association, *, twice: bool
) -> Bools:
    """Return which blobs, (M,), are duplicates: of those of confirmed tracks none is.

    Of any others, that of the older track is kept, or else the first. A point that is a confirmed
    track's only if that has turned is one of the others if the detector finds things twice: it may
    be its neighbor's. Of points that are nobody's none is: each starts a track, which is confirmed
    only if the others go elsewhere.
    """
    pairs, duplicate = associated.pairs, np.zeros(len(blobs), bool)
    state = prediction.records['state'][pairs.track]
    half, point = blobs.size / 2, blobs.size[:, 0] <= 0
    unsure = state == TENTATIVE
    if twice:
        unsure |= _has_turned(pairs) & point[pairs.blob]
    # 0 for blobs of confirmed tracks, and then in the order in which others are kept
    last = len(prediction.center) + 1 + np.arange(len(blobs))
    rank = np.where(associated.free, last, 0)
    rank[pairs.blob] = np.where(unsure, 1 + pairs.track, 0)
    center, later = (blobs.box[:, 0] + blobs.box[:, 1]) / 2, rank.nonzero()[0]
    half[point] = np.sqrt(TWO_OF_ONE * blobs.variance[point])
    one, other = points_inside(center, half, center[later], MOST_COINCIDENT)
    other, color = later[other], blobs.rows['color']
    near = (rank[one] < rank[other]) & (color[one] == color[other]) & (point[one] == point[other])
    near &= ~(point & associated.free)[one]
    one, other = one[near], other[near]
    same = np.where(point[one], _are_near(blobs, one, other), _coincide(blobs, one, other))
    duplicate[other[same]] = True
    return duplicate


def _are_near(blobs: Measurements, one: Indices, other: Indices) -> Bools:
    """Whether points, (K,), are no further apart than TWO_OF_ONE says, for the noise of `one`."""
    e = blobs.z[other] - blobs.z[one]
    inverse, _ = invert(blobs.R[one])
    return np.asarray(np.einsum('ki,kij,kj->k', e, inverse, e) < TWO_OF_ONE)


def _coincide(blobs: Measurements, one: Indices, other: Indices) -> Bools:
    """Whether boxes, (K,), have more than SAME_OBJECT in common."""
    low = np.maximum(blobs.box[one, 0], blobs.box[other, 0])
    high = np.minimum(blobs.box[one, 1], blobs.box[other, 1])
    common = np.maximum(high - low, 0.0).prod(axis=1)
    area = blobs.size.prod(axis=1)
    return np.asarray(common > SAME_OBJECT * (area[one] + area[other] - common))
