"""Several detectors on one topic, such as that of colors and a network, that find the same objects.

What the second one finds where the first one has found an object, at the same stamp, is that
object: it is no further away than boxes err, which is more than duplicates of one detector do. Of
a message with detections of both kinds, those that state a covariance come first.
"""

from dataclasses import replace

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Detections
from colortrack_ros.data import Indices
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.track_table import marked
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.overlaps import LIKE_SIDES
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.rectangles import points_inside

NEAR_MIDDLE = 0.25
"""Distance of the middle of a box from that of the object that it is of, over the size, by axis:
boxes of a network are off by 0.05 (box_errors.py), and may be half as large again. Assumed."""

NEAR_POINT = 9.21
"""Squared distance of a point from the object that it is of, over the variances of both, by axis:
1 % are further away (chi-square, two degrees of freedom)."""

MOST_FOUND = 16
"""Detections compared with each track where there are many, to bound the time. Assumed."""


def by_kind(detections: Detections) -> tuple[Detections, ...]:
    """The detections that state a covariance, and those that do not, if there are both."""
    rows = detections.rows
    stated = rows['cov_uu'] > 0
    if not 0 < np.count_nonzero(stated) < stated.size:
        return (detections,)
    return replace(detections, rows=rows[stated]), replace(detections, rows=rows[~stated])


def may_take(prediction: Prediction, blobs: Measurements, track: Indices, blob: Indices) -> Bools:
    """Whether tracks, (K,), may take blobs, (K,): those not measured yet; if tentative, no blob of
    another.
    """
    unsure = prediction.records['state'][track] == TENTATIVE
    of_another = unsure & found_before(prediction, blobs)[blob]
    return np.asarray((prediction.unmeasured[track] > 0) & ~of_another)


def found_before(prediction: Prediction, blobs: Measurements) -> Bools:
    """Return which blobs, (M,), are of tracks that have been measured at this stamp before."""
    measured = (prediction.unmeasured <= 0).nonzero()[0]
    size = prediction.size[measured]
    variance = prediction.variance[measured] + blobs.variance.max(axis=0, initial=0.0)
    half = np.where(size > 0, NEAR_MIDDLE * size, np.sqrt(NEAR_POINT * variance))
    middle = blobs.box.sum(axis=1) / 2
    track, blob = points_inside(prediction.center[measured], half, middle, MOST_FOUND)
    size, beside = size[track], blobs.size[blob]
    alike = np.maximum(size, beside) < LIKE_SIDES * np.minimum(size, beside)
    same = (alike | (size <= 0) | (beside <= 0)).all(axis=1)
    same &= prediction.records['color'][measured[track]] == blobs.rows['color'][blob]
    return marked(blob[same], len(blobs))
