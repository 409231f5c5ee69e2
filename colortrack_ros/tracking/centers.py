"""Centers: what a blob that is whole, cut, or merged measures of the center of an object.

A track remembers how far its object reaches from the centroid to each side of its box. A blob
narrower than that is cut (an occluder, the edge of the picture), a wider one is merged with
another. Either way one of its two sides is still a side of the object, and gives its center.
"""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.tracking.measurements import by_axis
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.merged import EDGE_VARIANCE
from colortrack_ros.tracking.merged import sides_of_several
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.sizes import Sizes
from colortrack_ros.tracking.sizes import tolerance

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.intp]

TIED = 0.75
"""A box that lies about its centroid as ever says nothing that the centroid does not: its sides
come from the same fit, or from the same network, and are off by as much. Boxes are rounded to whole
pixels, and extents are learned from such, so they lie otherwise by half a pixel and a little [px].
With 0.5 and 0.75 three real cups, at several sizes of the picture, are followed as well."""

FEW_PAIRS = 100
"""Pairs up to which all are looked at where only some are in doubt, which are no others than would
be changed: picking them takes longer."""

LASTING = 4.0
"""Number of frames in which the doubt about the side makes the same error: variances are multiplied
by it, as the filter takes errors of successive frames to be independent. Assumed."""


def measure_centers(
    prediction: Prediction,
    blobs: Measurements,
    track: Indices,
    blob: Indices,
    shared: Bools | None,
) -> tuple[Floats, Floats]:
    """What blobs measure of the centers of objects, and how well.

    :param blobs: of the frame.
    :param track, blob: (K,) which object, by which blob.
    :param shared: (K,) pairs whose blob is shared by several tracks; None if there are none.
    :return: (K, 2) [px], and its covariance (K, 2, 2) [px^2].
    """
    z, R = blobs.z.take(blob, axis=0), blobs.R.take(blob, axis=0)
    if not prediction.sized:
        return z, R
    size, variance = prediction.size.take(track, axis=0), by_axis(R)
    visible = blobs.size.take(blob, axis=0)
    odd = blobs.cut.take(blob, axis=0) & (visible < size) if prediction.finds_whole else True
    if np.count_nonzero(odd):
        variance += odd * _variance_of_odd(prediction.sizes, size, visible)
    of_side = side_variance(prediction, blobs, blob, size)
    doubtful = (variance > of_side) & (size > 0)
    either = doubtful[:, 0] | doubtful[:, 1]
    if shared is not None:
        either |= shared
    some = either.nonzero()[0]
    if len(some) and (len(some) == len(track) or len(track) <= FEW_PAIRS):
        _take_sides(prediction, blobs, track, blob, size, of_side, shared, z, R)
    elif len(some):
        ours = None if shared is None else shared[some]
        z_some, R_some = z[some], R[some]
        pairs = track[some], blob[some], size[some], of_side[some]
        _take_sides(prediction, blobs, *pairs, ours, z_some, R_some)
        z[some], R[some] = z_some, R_some
    return z, R


def _variance_of_odd(sizes: Sizes, size: Floats, blob: Floats) -> Floats:
    """What blobs of another size add to the variance of the center, (K, 2), by axis [px^2].

    As the center of the object a centroid may be off by half of what the sizes differ by, beyond a
    pixel or what boxes jitter by. That is of blobs; sides that err independently have a sum that
    says nothing of their difference, and what centers of such boxes err by is learned.

    :param size, blob: (K, 2) of the objects and of the blobs [px].
    """
    excess = np.abs(blob - size)
    excess -= 1 if sizes.are_steady else 1 + sizes.slack(size) - tolerance(size)
    np.maximum(excess, 0, out=excess)
    excess *= excess
    return np.asarray(LASTING * excess / 4)


def side_variance(
    prediction: Prediction, blobs: Measurements, blob: Indices, size: Floats
) -> Floats:
    """Of the centers that sides give, (K, 2), by axis [px^2].

    A box that jitters is known no better by a side than by its center.

    :param blob: (K,) which.
    :param size: (K, 2) of the objects [px].
    """
    jittering = blobs.usual.take(blob, axis=0)
    if not prediction.sizes.are_steady:
        jittering += prediction.sizes.variance(size) / 4
    return np.asarray(np.maximum(EDGE_VARIANCE, jittering))


def _take_sides(
    prediction: Prediction,
    blobs: Measurements,
    track: Indices,
    blob: Indices,
    size: Floats,
    of_side: Floats,
    shared: Bools | None,
    z: Floats,
    R: Floats,
) -> None:
    """Write the centers that sides give over z, (K, 2), and R, (K, 2, 2), where they are better.

    That is for each axis the mixture of the three centers, replaced by its mean and variance. The
    sides are no better where the box is tied to the centroid. While an object comes into the
    picture, its size is as little known as how far it goes on outside.

    :param size: (K, 2) of the objects [px], 0 where nothing is known of them.
    :param of_side: (K, 2) see side_variance() [px^2].
    """
    records = prediction.records
    center = centers(z, blobs.box.take(blob, axis=0), records['extent'].take(track, axis=0))
    weight = _sides(prediction, blobs, track, blob, shared, center, of_side)
    mean = np.add.reduce(weight * center)
    rest = center - mean
    variance = of_side + LASTING * np.add.reduce(weight * (rest * rest))
    partial = records['partial'][track]
    if np.count_nonzero(partial):
        variance += np.where(partial, blobs.variance[blob], 0.0)
    given = by_axis(R)
    tied = np.ptp(center, axis=0).max(axis=1) <= TIED
    better = (variance < given) & (size > 0) & ~tied[:, None]
    np.copyto(z, mean, where=better)
    np.copyto(given, variance, where=better)
    np.copyto(R.reshape(-1, 4)[:, 1:3], 0.0, where=(better[:, :1] | better[:, 1:]))


def _sides(
    prediction: Prediction,
    blobs: Measurements,
    track: Indices,
    blob: Indices,
    shared: Bools | None,
    center: Floats,
    of_side: Floats,
) -> Floats:
    """Probabilities of the three centers, (3, K, 2), by the prediction and who shares the blob.

    Where one side of an object is out of the picture, the other is known to be its own.
    """
    expected = prediction.center.take(track, axis=0)
    variance = prediction.variance.take(track, axis=0)
    d2 = center - expected
    d2 *= d2
    d2 /= variance + of_side
    weight = np.exp((np.minimum.reduce(d2) - d2) / 2)
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


def centers(z: Floats, box: Floats, extent: Floats) -> Floats:
    """Where the object's center is if the low side of the blob is its own, neither, or the high.

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
