"""Duplicates: several detections of one object in the same frame, as of a detector without NMS.

Two objects hardly ever have nearly the same box, and never for long. So of boxes that coincide, as
many are kept as there are confirmed tracks that take them, and one where there is none.
"""

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import TENTATIVE
from colortrack_ros.tracking.hypotheses import Association
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.rectangles import points_inside

SAME_OBJECT = 0.7
"""Intersection over union above which two boxes are of one object: that above which Faster R-CNN
suppresses one (Ren et al. 2015, 3.3). With 0.5, all duplicates of boxes of 40 px whose sides err by
3 px are found, but people side by side in public detections lose 2 points of IDF1."""

MOST_COINCIDENT = 16
"""Boxes compared with each where there are many, to bound the time. Assumed."""


def leave_out_duplicates(
    prediction: Prediction, blobs: Measurements, associated: Association
) -> tuple[Association, Measurements]:
    """Return the association and the blobs without duplicates, which start and confirm nothing."""
    duplicate = _find(prediction, blobs, associated)
    if not np.count_nonzero(duplicate):
        return associated, blobs
    pairs, probability, free, hard = associated
    kept = (~duplicate[pairs.blob]).nonzero()[0]
    free = free & ~duplicate
    return Association(pairs.take(kept), probability[kept], free, hard), blobs.take(~duplicate)


def _find(prediction: Prediction, blobs: Measurements, associated: Association) -> Bools:
    """Return which blobs, (M,), are duplicates: of those of confirmed tracks none is.

    Of any others, that of the older track is kept, or else the first.
    """
    pairs, duplicate = associated.pairs, np.zeros(len(blobs), bool)
    state = prediction.records['state'][pairs.track]
    tentative = state == TENTATIVE
    # 0 for blobs of confirmed tracks, and then in the order in which others are kept
    rank = len(prediction.center) + 1 + np.arange(len(blobs))
    rank[pairs.blob] = np.where(tentative, 1 + pairs.track, 0)
    center, later = (blobs.box[:, 0] + blobs.box[:, 1]) / 2, rank.nonzero()[0]
    one, other = points_inside(center, blobs.size / 2, center[later], MOST_COINCIDENT)
    other, color = later[other], blobs.rows['color']
    near = ((rank[one] < rank[other]) & (color[one] == color[other])).nonzero()[0]
    one, other = one[near], other[near]
    low = np.maximum(blobs.box[one, 0], blobs.box[other, 0])
    high = np.minimum(blobs.box[one, 1], blobs.box[other, 1])
    common = np.maximum(high - low, 0.0).prod(axis=1)
    area = blobs.size.prod(axis=1)
    duplicate[other[common > SAME_OBJECT * (area[one] + area[other] - common)]] = True
    return duplicate
