"""Centers: the center of an object as measured by a blob that is complete, cut, or merged.

A track knows how far its object extends from the centroid to each side of its box. A narrower blob
is cut (by an occluder, or the edge of the picture), a wider one is merged with another. Either way
one of its two sides is still a side of the object, and gives its center.
"""

import math

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.tracking.growth import FASTEST_GROWTH
from colortrack_ros.tracking.measurements import both_axes
from colortrack_ros.tracking.measurements import by_axis
from colortrack_ros.tracking.measurements import either_axis
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.merged import EDGE_VARIANCE
from colortrack_ros.tracking.merged import sides_of_several
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.sizes import OTHER_SIZE
from colortrack_ros.tracking.sizes import Sizes
from colortrack_ros.tracking.sizes import TOLERANCE
from colortrack_ros.tracking.sizes import tolerance
from colortrack_ros.tracking.sizes import TOLERANCE_SHARE
from colortrack_ros.tracking.sizes import total

TIED = 0.75
"""Largest deviation of a box, relative to its centroid, from the learned extent at which its sides
add no information [px]: they come from the same fit, or the same network, and share the centroid's
error. Boxes are rounded to whole pixels, and extents are learned from them, so they deviate by a
little more than half a pixel. 0.5 and 0.75 do equally well on three real cups in several sizes."""

LASTING = 4.0
"""Number of frames for which the centroid of a box of another size has the same error. Variances
are multiplied by it, since the filter assumes independent errors in successive frames. Assumed."""

CHOSEN = 1 / 3
"""Time for which a wrong choice of side makes the same error [s], though no less than LASTING
frames. Assumed: a bar that turns looks narrower for that long; with 0.13 s it is lost by 200 px at
30 Hz, with 3 s what turns back behind a cover is."""

LOG_OTHER_SIZE = math.log(OTHER_SIZE)
"""Prior of neither side being the object's own, which then looks smaller or larger than it is."""


def measure_centers(
    prediction: Prediction, blobs: Measurements, track: Indices, blob: Indices, shared: Bools | None
) -> tuple[Floats, Floats]:
    """Centers of objects as measured by blobs, and their covariances.

    :param blobs: of the frame.
    :param track, blob: (K,) indices of objects and blobs.
    :param shared: (K,) pairs whose blob is shared by several tracks; None if there are none.
    :return: (K, 2) [px], and covariances (K, 2, 2) [px^2].
    """
    z, R = blobs.z.take(blob, axis=0), blobs.R.take(blob, axis=0)
    if not prediction.sized:
        return z, R
    size, variance = prediction.size.take(track, axis=0), by_axis(R)
    visible = blobs.size.take(blob, axis=0)
    if not prediction.finds_whole:
        variance += _variance_of_odd(prediction.sizes, size, visible)
    elif np.count_nonzero(odd := blobs.cut.take(blob, axis=0) & (visible < size)):
        variance += odd * _variance_of_odd(prediction.sizes, size, visible)
    of_side = side_variance(prediction, blobs, blob, size)
    doubtful = variance > of_side
    if shared is None and not np.count_nonzero(doubtful):
        return z, R  # as nearly always where no gate holds the blob of another
    either = either_axis(doubtful & (size > 0))
    some = (either if shared is None else either | shared).nonzero()[0]
    if len(some):
        scaled, free, center = _compared(prediction, blobs, track[some], blob[some])
        if shared is not None:
            scaled &= ~shared[some]
            free |= shared[some]
        R[some[scaled]] = blobs.R[blob[some[scaled]]]
        free &= ~scaled
        some, center = some[free], center[:, free]
    if len(some):
        ours = None if shared is None else shared[some]
        pairs = track[some], blob[some], size[some], of_side[some]
        z[some], R[some] = _take_sides(prediction, blobs, *pairs, ours, center, R[some])
    return z, R


def _possible(prediction: Prediction, blobs: Measurements, track: Indices, blob: Indices) -> Floats:
    """Centers, (3, K, 2), that the sides and the centroids of blobs give; see centers()."""
    extent = prediction.records['extent'].take(track, axis=0)
    return centers(blobs.z.take(blob, axis=0), blobs.box.take(blob, axis=0), extent)


def _are_free(center: Floats) -> Bools:
    """Which centers, (3, K, 2), lie apart: sides that are not TIED to the centroid, (K,)."""
    return either_axis(np.maximum.reduce(center) - np.minimum.reduce(center) > TIED)


def are_scaled(prediction: Prediction, blobs: Measurements, track: Indices, blob: Indices) -> Bools:
    """Which blobs, (K,), may be their objects as seen from nearer or farther.

    Both axes change by one factor, and the centroid keeps its place within the box. Of what is cut,
    or merged with another, one side alone moves, which changes the aspect. Boxes that jitter do not
    show it, nor do changes within the tolerance, see _compared().

    :param track, blob: (K,) indices of objects and blobs.
    """
    if not prediction.sizes.are_steady:
        return np.zeros(len(track), bool)
    extent, reach = prediction.records['extent'].take(track, axis=0), blobs.reach(blob)
    size, visible = np.maximum(total(extent), 1.0), np.maximum(total(reach), 1.0)
    factor = visible / size
    log = np.log(factor)
    rounded = TOLERANCE * np.hypot(*(1 / visible.T)) / math.sqrt(2)
    most = FASTEST_GROWTH * prediction.step.period + rounded
    one = (np.abs(log[:, 0] - log[:, 1]) <= rounded) & (np.abs(log[:, 0]) <= most)
    one &= ~(either_axis(blobs.cut) | blobs.mixed)[blob]
    one &= both_axes(np.abs(reach[:, 0] - factor * extent[:, 0]) <= TOLERANCE)
    return np.asarray(one)


def _compared(
    prediction: Prediction, blobs: Measurements, track: Indices, blob: Indices
) -> tuple[Bools, Bools, Floats]:
    """Which pairs, (K,), are scaled, which of their centers lie apart, and the centers, (3, K, 2).

    A size within the tolerance does not show the scale: there the centroid has to be nearest to
    where it is expected.
    """
    center = _possible(prediction, blobs, track, blob)
    away = blobs.size.take(blob, axis=0) - prediction.size.take(track, axis=0)
    aside = np.abs(center - prediction.center.take(track, axis=0))
    shown = both_axes(np.abs(away) > TOLERANCE)
    shown |= both_axes(aside[1] <= np.minimum(aside[0], aside[2]))
    return are_scaled(prediction, blobs, track, blob) & shown, _are_free(center), center


def _variance_of_odd(sizes: Sizes, size: Floats, blob: Floats) -> Floats:
    """Variance that a difference in size adds to the center, (K, 2), by axis [px^2].

    The centroid may be off by half the difference in size, beyond a pixel or the jitter of boxes.
    This holds for blobs. Where sides err independently, their sum says nothing about their
    difference, and the error of the center is learned instead.

    :param size, blob: (K, 2) of the objects and of the blobs [px].
    """
    excess = np.abs(blob - size)
    excess -= 1 if sizes.are_steady else 1.0 + sizes.slack(size) - tolerance(size)
    np.maximum(excess, 0, out=excess)
    excess *= excess
    excess *= LASTING / 4
    return excess


def side_variance(
    prediction: Prediction, blobs: Measurements, blob: Indices, size: Floats
) -> Floats:
    """Variance of centers derived from sides, (K, 2), by axis [px^2].

    Sides of boxes that jitter are no more accurate than their centers.

    :param blob: (K,) indices.
    :param size: (K, 2) of the objects [px].
    """
    jittering = blobs.usual.take(blob, axis=0)
    if not prediction.sizes.are_steady:
        jittering += prediction.sizes.variance(size) / 4.0
    return np.maximum(EDGE_VARIANCE, jittering)


def _take_sides(
    prediction: Prediction,
    blobs: Measurements,
    track: Indices,
    blob: Indices,
    size: Floats,
    of_side: Floats,
    shared: Bools | None,
    center: Floats,
    R: Floats,
) -> tuple[Floats, Floats]:
    """Centers of objects, (K, 2), and R, (K, 2, 2), derived from sides where these are better.

    Sides are no better where the box is tied to the centroid. Of an object that turns, bends, or
    gets into a shade the blob has other extents than those learned; whole boxes do not show it.
    While an object enters the picture, its size is unknown, as is how far it extends outside.

    :param size: (K, 2) of the objects [px], 0 where unknown.
    :param of_side: (K, 2) see side_variance() [px^2].
    :param center: (3, K, 2) see centers() [px].
    :param R: (K, 2, 2) of the centroids [px^2].
    """
    shape = 0.0 if prediction.finds_whole else TOLERANCE_SHARE * size
    variance = _variances(center, of_side + shape * shape)
    weight = _sides(prediction, blobs, track, blob, shared, center, variance)
    lasting = max(LASTING, CHOSEN / prediction.step.period)
    mean, variance = _as_one(center, variance, weight, lasting)
    partial = prediction.records['partial'][track]
    if np.count_nonzero(partial):
        variance += np.where(partial, blobs.variance[blob], 0.0)
    given = by_axis(R)
    better = (variance < given) & (size > 0)
    if shared is not None:
        better &= _are_free(center)[:, None]
    np.copyto(given, variance, where=better)
    np.copyto(R.reshape(-1, 4)[:, 1:3], 0.0, where=(better[:, :1] | better[:, 1:]))
    return np.where(better, mean, center[1]), R


def _variances(center: Floats, of_side: Floats) -> Floats:
    """Variances of the three centers, (3, K, 2) [px^2].

    If neither side is its own, an object is anywhere between the centers that they give.

    :param of_side: (K, 2) of a center that a side gives [px^2].
    """
    between = center[2] - center[0]
    return np.array([of_side, of_side + between * between / 12.0, of_side])


def _as_one(
    center: Floats, variance: Floats, weight: Floats, lasting: float
) -> tuple[Floats, Floats]:
    """One measurement, (K, 2) [px], and its variance [px^2], for three centers, (3, K, 2).

    They are averaged by the information that each adds, so that the least certain one counts only
    if it is by far the most probable. What they differ by lasts for that many frames.
    """
    share = weight / variance
    total = 1.0 / np.add.reduce(share)
    share *= total
    mean = np.add.reduce(share * center)
    rest = center - mean
    return mean, total + lasting * np.add.reduce(share * (rest * rest))


def _sides(
    prediction: Prediction,
    blobs: Measurements,
    track: Indices,
    blob: Indices,
    shared: Bools | None,
    center: Floats,
    S: Floats,
) -> Floats:
    """Probabilities of the three centers, (3, K, 2), by the prediction and by who shares the blob.

    The prediction allows for a maneuver. Where one side of a box ends at the border of the picture,
    the other one is the object's own.

    :param S: (3, K, 2) variances of the centers [px^2].
    """
    expected = prediction.center.take(track, axis=0)
    variance = prediction.variance.take(track, axis=0)
    chance = prediction.maneuvered[track][:, None]
    turn = prediction.turn_speed(track) * prediction.unmeasured[track][:, None]
    e = center - expected
    wide = variance + S
    log = _log_normal(e, wide) + np.log(np.maximum(1.0 - chance, TINY))
    turned = _log_normal(e, wide + turn * turn / 3.0) + np.log(np.maximum(chance, TINY))
    np.logaddexp(log, turned, out=log)
    log[1] += LOG_OTHER_SIZE
    weight = np.exp(log - np.maximum.reduce(log))
    weight /= np.add.reduce(weight)
    if prediction.finds_whole and np.count_nonzero(blobs.outside):
        outside = blobs.outside.take(blob, axis=0)
        outside *= blobs.size.take(blob, axis=0) < prediction.size.take(track, axis=0)
        weight[:, outside != 0] = 0.0
        weight[0, outside > 0] = weight[2, outside < 0] = 1.0
    if shared is not None and shared.any():
        one = np.flatnonzero(shared)
        weight[:, one] = sides_of_several(
            blobs, blob[one], center[:, one], expected[one], variance[one]
        )
    return weight


def _log_normal(e: Floats, variance: Floats) -> Floats:
    """Log of the density of e, up to a constant."""
    return np.asarray(-(e * e / variance + np.log(variance)) / 2.0)


def centers(z: Floats, box: Floats, extent: Floats) -> Floats:
    """Centers of the objects if the low side of the blob is their own, neither, or the high one.

    :param z: (K, 2) centroid [px].
    :param box: (K, 2, 2) sides of the blob [px].
    :param extent: (K, 2, 2) extent of the object [px].
    :return: (3, K, 2) [px].
    """
    center = np.empty((3, *z.shape))
    np.add(box[:, 0], extent[:, 0], out=center[0])
    center[1] = z
    np.subtract(box[:, 1], extent[:, 1], out=center[2])
    return center
