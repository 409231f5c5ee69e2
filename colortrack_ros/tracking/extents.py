"""Extents: the size of each object, learned from the blobs that it does not share."""

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.centers import are_scaled
from colortrack_ros.tracking.centers import centers
from colortrack_ros.tracking.growth import FOLLOWING_SHARE
from colortrack_ros.tracking.growth import learn_growth
from colortrack_ros.tracking.growth import learn_scaling
from colortrack_ros.tracking.growth import STEADY_SIDE
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.measurements import both_axes
from colortrack_ros.tracking.measurements import either_axis
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import LAST_FRAME
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.sizes import TOLERANCE
from colortrack_ros.tracking.sizes import TOLERANCE_SHARE
from colortrack_ros.tracking.sizes import total

# Constants marked "assumed" were set by hand; benchmark/ablation.py --constants extents.NAME shows
# what IDF1 becomes with half and twice the value.

GROWING, SHRINKING = 0.3, 2.0
"""Time constants of the learned size [s]: towards a blob that is suddenly larger, or smaller and
remains so; and towards one that is smaller and does not. Assumed."""

STEADY_SIZE = 2 * STEADY_SIDE
"""Difference of sizes [px] that steady boxes of an object may have: either side is off by as much
as it may be."""


def update_extents(
    tracks: TrackTable[Bank], prediction: Prediction, blobs: Measurements, taken: Hypotheses
) -> tuple[Bools, Indices | None]:
    """Learn extents from blobs with a single track; return which are complete, and which are odd.

    While an object comes into view its centroid moves at half its speed.

    :return: (K,) which have the size of their objects; indices of those whose size is another one
        by more than a pixel, or that are edged, None if there are none, see edges.
    """
    track, blob, records = taken.track, taken.blob, tracks.records
    if not prediction.sized:
        return np.ones(len(track), bool), None
    rows = slice(None) if len(track) == len(records) else track
    extent = records['extent'][rows]
    excess = blobs.size.take(blob, axis=0) - prediction.size[rows]
    away = np.abs(excess)
    unlike, scaled = np.zeros(len(track), bool), None
    grows = np.count_nonzero(away > STEADY_SIZE)
    if grows:  # else all are within the tolerance, which is larger
        unlike = either_axis(away > prediction.slack[rows])
        scaled = _scaled(prediction, blobs, taken, away, unlike)
    watched = grows or np.count_nonzero(records['edged'])
    odd = _odd(prediction, blobs, taken, away) if watched else None
    now = _followed(prediction, blobs, taken, extent, excess, unlike, scaled)
    if np.count_nonzero(blobs.mixed):
        mixed = blobs.mixed[blob]
        now[mixed] = extent[mixed]
        unlike |= mixed
    if grows or np.count_nonzero(records['growth']):
        _learn_growth(prediction, blobs, track, blob, unlike, scaled)
    if scaled is not None:
        learn_scaling(records, track[scaled], excess[scaled], prediction.step.period)
    records['extent'][rows] = now
    if np.count_nonzero(records['partial']):
        records['partial'][track] &= blobs.cut[blob] | unlike[:, None]
    if np.count_nonzero(unlike):
        _doubt_unlike(tracks, prediction, blobs, taken, extent, total(now))
    return ~unlike, odd


def _doubt_unlike(
    tracks: TrackTable[Bank], prediction: Prediction, blobs: Measurements, taken: Hypotheses,
    extent: Floats, now: Floats,
) -> None:  # fmt: skip
    """Doubt velocities by sudden growth, and publish the error of the extents of what is cut.

    A side's center has that error in every frame. The filter averages it, as it averages noise, but
    it is the same for as long as the cut lasts.

    :param extent: (K, 2, 2) of the objects [px].
    :param now: (K, 2) their sizes as of this frame [px].
    """
    size, slack = prediction.size[taken.track], prediction.slack[taken.track]
    growth = np.where(now - size < slack, 0.0, now - size)
    tracks.filters.doubt_velocity(taken.track, (growth / 2 / prediction.step.period) ** 2)
    if prediction.finds_whole:
        return
    cut = blobs.size[taken.blob] - size < -slack
    cut &= _are_off(prediction, blobs, taken.track, taken.blob, extent)
    cut[blobs.mixed[taken.blob]] = False
    blobs.systematic[taken.blob] += cut * (TOLERANCE_SHARE * size) ** 2


def _followed(
    prediction: Prediction, blobs: Measurements, taken: Hypotheses, extent: Floats,
    excess: Floats, unlike: Bools, scaled: Indices | None,
) -> Floats:  # fmt: skip
    """Extents, (K, 2, 2), that follow those of the blobs, see update_extents().

    :param excess: (K, 2) of their sizes [px].
    :param unlike, scaled: which have another size, and indices of those with another scale, if any.
    """
    reach = blobs.reach(taken.blob)
    now = extent + FOLLOWING_SHARE * (reach - extent)
    if scaled is not None:
        now[scaled] = reach[scaled] + (now - reach)[scaled].clip(-TOLERANCE / 2, TOLERANCE / 2)
    if np.count_nonzero(unlike):
        one = unlike.nonzero()[0]
        track = taken.track[one]
        beyond = np.where(np.abs(excess[one]) > prediction.slack[track], excess[one], 0.0)
        of_one = track, taken.blob[one], extent[one], reach[one]
        now[one] = _learn_unlike(prediction, blobs, *of_one, beyond)
    return _uncut(prediction, blobs, taken.blob, now, extent)


def _odd(
    prediction: Prediction, blobs: Measurements, taken: Hypotheses, away: Floats
) -> Indices | None:
    """Indices of blobs that a cover may cut, see update_extents().

    Boxes of whole objects, or that jitter, do not show it, nor do those of several.

    :param away: (K, 2) difference of their sizes [px].
    """
    if prediction.finds_whole or not prediction.sizes.are_steady:
        return None
    odd = either_axis((away > STEADY_SIZE) | prediction.records['edged'][taken.track])
    return (odd & ~blobs.mixed[taken.blob]).nonzero()[0]


def _scaled(
    prediction: Prediction, blobs: Measurements, taken: Hypotheses, away: Floats, unlike: Bools
) -> Indices | None:
    """Indices of those whose blobs are seen from nearer or farther, which are not unlike then.

    :param away: (K, 2) difference of their sizes [px].
    :param unlike: (K,) changed here.
    """
    both = both_axes(away > TOLERANCE).nonzero()[0]
    if len(both):
        both = both[are_scaled(prediction, blobs, taken.track[both], taken.blob[both])]
        unlike[both] = False
    return both if len(both) else None


def _uncut(
    prediction: Prediction, blobs: Measurements, blob: Indices, now: Floats, extent: Floats
) -> Floats:
    """The extents now, (K, 2, 2), or the previous ones where the border cuts a complete box."""
    if not (prediction.finds_whole and np.count_nonzero(blobs.cut)):
        return now
    shrinks = blobs.cut[blob] & (total(now) < total(extent))
    return np.where(shrinks[:, None], extent, now)


def _learn_growth(
    prediction: Prediction, blobs: Measurements, track: Indices, blob: Indices, unlike: Bools,
    scaled: Indices | None,
) -> None:  # fmt: skip
    """Learn the growth of objects, (K,), from how far the sides of their blobs have moved."""
    records = prediction.records
    moved = blobs.box[blob] - prediction.center[track][:, None]
    np.negative(moved[:, 0], out=moved[:, 0])
    moved -= records['extent'][track]
    cut = blobs.cut[blob] | records['partial'][track]
    if scaled is not None:
        cut[scaled] = True
    learn_growth(records, track, moved, cut, unlike, prediction.step.period)


def _learn_unlike(
    prediction: Prediction,
    blobs: Measurements,
    track: Indices,
    blob: Indices,
    extent: Floats,
    reach: Floats,
    excess: Floats,
) -> Floats:
    """Extents after an unshared blob of another size.

    A blob that grows by no more than the object moves, as one coming into view does, is followed at
    once. A sudden growth may be that of a merged blob, and is followed more slowly. A smaller blob
    is followed slowest, and only if its centroid is closer to the prediction than the centers that
    either side gives, or if it keeps its size from the last frame on: otherwise the object is not
    smaller but cut. What comes out from behind a cover is as narrow as when it was last seen there.
    What had no box yet is as large as its first.

    :param extent: (K, 2, 2) of the objects [px].
    :param reach: (K, 2, 2) of the blobs, see Measurements.reach() [px].
    :param excess: (K, 2) of their sizes, 0 within the tolerance [px].
    :return: (K, 2, 2) [px].
    """
    records = prediction.records
    last = records['box_size'][track]
    small = excess < most_growth(prediction, track)
    growing = (excess > 0) & (small[:, :1] & small[:, 1:]) | (total(extent) <= 0)
    cut = _are_off(prediction, blobs, track, blob, extent)
    steady = (np.abs(reach.sum(axis=1) - last) < TOLERANCE).all(axis=1)[:, None]
    steady &= (prediction.unseen[track] < LAST_FRAME * prediction.step.period)[:, None]
    time = np.where((excess > 0) | steady, GROWING, np.where(cut, np.inf, SHRINKING))
    slow = 1 - np.exp(-prediction.step.period / time)
    rate = np.where(excess == 0, FOLLOWING_SHARE, np.where(growing, 1.0, slow))
    return extent + rate[:, None] * (reach - extent)


def _are_off(
    prediction: Prediction, blobs: Measurements, track: Indices, blob: Indices, extent: Floats
) -> Bools:
    """Whether a side of the blob gives a center nearer to the prediction than its own, (K, 2)."""
    aside = centers(blobs.z[blob], blobs.box[blob], extent) - prediction.center[track]
    return np.asarray(np.abs(aside).argmin(axis=0) != 1)


def most_growth(prediction: Prediction, track: Indices) -> Floats:
    """How much of objects, (K, 1), may have come into view in this frame [px].

    It is how far they may have moved, at two standard deviations.
    """
    cov = prediction.bank.estimate()[1]
    variance = cov[track, 2, 2] + cov[track, 3, 3]
    speed = np.hypot(*prediction.velocity[track].T) + 2 * np.sqrt(variance)
    return np.asarray(4 * TOLERANCE + speed * prediction.step.period)[:, None]
