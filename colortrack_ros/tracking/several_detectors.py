"""Several detectors on one topic, such as that of colors and a network, that find the same objects.

What the second one finds where the first one has found an object, at the same stamp, is that
object: it is no further away than boxes err, which is more than duplicates of one detector do. Of
a message, what states no covariance and lies on what does comes after the rest. All of a detector
that states only some covariances remains one frame: else tracks would take what is of others.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Detections
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.track_table import marked
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.measurements import LARGEST_SQUARE
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.overlaps import are_like
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


def by_kind(detections: Detections, config: TrackerConfig) -> tuple[Detections, ...]:
    """The detections, and then what a second detector has found in their place, if there is any.

    More than are worked on remain one part, so that the bound is of both.
    """
    rows = detections.rows
    stated = rows['cov_uu'] > 0
    if not 0 < np.count_nonzero(stated) < stated.size <= config.max_detections:
        return (detections,)
    again = _found_twice(rows, stated, config.measurement_noise)
    if not np.count_nonzero(again):
        return (detections,)
    return replace(detections, rows=rows[~again]), replace(detections, rows=rows[again])


def _found_twice(rows: NDArray[np.void], stated: Bools, noise: float) -> Bools:
    """Which rows, (N,) of dtype DETECTION, state no covariance and lie on some that do.

    Nobody has looked at these rows yet: what is no number lies nowhere.

    :param noise: assumed of points without a covariance, as a standard deviation [px].
    """
    fields = 'u', 'v', 'box_u', 'box_v', 'box_w', 'box_h', 'cov_uu', 'cov_vv'
    values = np.stack([np.asarray(rows[name], np.float64) for name in fields], axis=1)
    usable = (np.abs(values) <= LARGEST_SQUARE).all(axis=1)
    one, two = (usable & stated).nonzero()[0], (usable & ~stated).nonzero()[0]
    values[~usable] = np.nan
    z, corner, size, variance = np.split(values, 4, axis=1)
    middle = np.where(size > 0, corner + (size - 1) / 2, z)
    half = _half(size[one], variance[one] + noise**2)
    first, second = points_inside(middle[one], half, middle[two], MOST_FOUND)
    first, second = one[first], two[second]
    same = _are_alike(size[first], size[second]) & (rows['color'][first] == rows['color'][second])
    return marked(second[same], rows.size)


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
    size, variance = prediction.size[measured], prediction.variance[measured]
    half = _half(size, variance + blobs.variance.max(axis=0, initial=0.0))
    center, middle = prediction.center[measured], blobs.box.sum(axis=1) / 2
    track, blob = points_inside(center, half, middle, MOST_FOUND)
    near = _half(size[track], variance[track] + blobs.variance[blob])
    same = (np.abs(middle[blob] - center[track]) <= near).all(axis=1)
    same &= _are_alike(size[track], blobs.size[blob])
    same &= prediction.records['color'][measured[track]] == blobs.rows['color'][blob]
    return marked(blob[same], len(blobs))


def _half(size: Floats, variance: Floats) -> Floats:
    """(N, 2) by axis, how far what is found of objects lies from their middles [px].

    :param size: (N, 2) of the objects, 0 of points [px]; variance: (N, 2) of both [px^2].
    """
    return np.where(size > 0, NEAR_MIDDLE * size, np.sqrt(NEAR_POINT * np.maximum(variance, 0.0)))


def _are_alike(size: Floats, beside: Floats) -> Bools:
    """Whether two sizes, (K, 2) each, may be of one object, (K,); those of points may."""
    return np.asarray((are_like(size, beside) | (size <= 0) | (beside <= 0)).all(axis=1))
