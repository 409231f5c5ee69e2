"""Update: filters, existence and sizes of tracks by what has been measured of them."""

import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.existence import update_existence
from colortrack_ros.estimation.existence import weigh_hidden
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.extents import centers
from colortrack_ros.tracking.extents import difference
from colortrack_ros.tracking.extents import FOLLOWING_SHARE
from colortrack_ros.tracking.extents import learn
from colortrack_ros.tracking.extents import slack
from colortrack_ros.tracking.extents import total
from colortrack_ros.tracking.hypotheses import Association
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.records import record_size
from colortrack_ros.tracking.second_difference import learn_acceleration

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.intp]

UNLIKELY = 0.01
"""Maneuvers less probable than this leave the filter alone, to save time: mixing one in would add a
hundredth of its covariance."""

MOST_LOG_RATIO = 50.0
"""Bound of a log-likelihood ratio, so that its exponential is finite; exp(50) leaves no doubt."""

OUTAGE, DIM = 0.01, 0.1
"""Probability that in a frame the camera or the detector fails, and that an object is detected
then all the same. Assumed: a frame in 3 s, and one object in ten."""

SURE = 0.9
"""Tracks that can be seen with at least this probability say whether there is an outage. Tentative
ones on clutter, which is detected once, would tell of one in every frame. Assumed."""

LOST, JUST_LOST = 4.5, 1.5
"""Frames after which an object was out of sight and not just missed, which in 95 % detected happens
four times on end once in 160,000; and within which it was measured in the last."""

FORMED_VELOCITY = 2
"""Hits after which a filter has a velocity that was measured (two-point differencing), so that its
innovations tell of the motion."""


def update(
    tracks: TrackTable[Bank],
    prediction: Prediction,
    blobs: Measurements,
    associated: Association,
    learned: Adaptation,
    config: TrackerConfig,
    *,
    now: int,
    period: float,
    again: bool,
) -> None:
    """Update filters, existence, sizes and what is learned of the scene.

    :param now: stamp of the frame [ns].
    :param period: since the last frame [s].
    :param again: these are more detections of a stamp that there were some of before.
    """
    pairs, probability = associated.pairs, associated.probability
    _update_existence(prediction, pairs, config, again=again)
    _learn_disappearances(prediction, pairs, learned, period, again=again)
    hard = np.count_nonzero(probability == 1) == len(probability)
    taken = pairs if hard else pairs.take(np.flatnonzero(probability > 0.5))
    whole = _update_sizes(tracks, prediction, blobs, taken, period)
    if not again:
        _learn(learned, prediction, blobs, taken, whole, config, period)
    _maneuver(tracks.filters, prediction, taken)
    if config.acceleration_span:
        learn_acceleration(tracks.records, taken.track, taken.z, now, config.acceleration_span)
    tracks.filters.correct(pairs.track, pairs.z, pairs.R, None if hard else probability)
    if learned.maneuvers.is_due(now):
        variance = (taken.R[whole, 0, 0] + taken.R[whole, 1, 1]) / 2
        learned.maneuvers.learn(
            tracks.records, taken.track[whole], taken.z[whole], variance,
            *tracks.filters.estimate(), now, prediction.speed,
        )  # fmt: skip
    tracks.records['misses'] += not again
    _record_hits(tracks, taken, blobs, now)


def _record_hits(
    tracks: TrackTable[Bank], taken: Hypotheses, blobs: Measurements, now: int
) -> None:
    """Note which tracks were measured, where, and how large."""
    tracks.records['misses'][taken.track] -= 1
    tracks.record_hits(taken.track, now)
    tracks.records['seen'][taken.track] = taken.z
    record_size(tracks.records, taken.track, blobs.rows[taken.blob])


def _maneuver(bank: Bank, prediction: Prediction, taken: Hypotheses) -> None:
    """Predict anew, by the measurements that they took, tracks that have maneuvered."""
    turned = (taken.innovations.maneuvered > UNLIKELY).nonzero()[0]
    if len(turned):
        track, maneuvered = taken.track[turned], taken.innovations.maneuvered[turned]
        bank.maneuver(track, maneuvered, prediction.unmeasured[track], prediction.speed)


def _update_existence(
    prediction: Prediction, pairs: Hypotheses, config: TrackerConfig, *, again: bool
) -> None:
    """Existence by the likelihood of what was measured, or of a miss (Musicki et al. 1994)."""
    p, records = config.detection_probability, prediction.records
    ratio = np.full(len(records), 1.0 if again else _missed(records['visible'], pairs.track, p))
    log_ratio = pairs.innovations.log_likelihood - prediction.log_density
    ratio += np.bincount(pairs.track, p * np.exp(np.minimum(log_ratio, MOST_LOG_RATIO)), len(ratio))
    records['visible'], records['hidden'] = update_existence(
        records['visible'], records['hidden'], ratio
    )


def _missed(visible: Floats, measured: Indices, p: float) -> float:
    """Probability of missing one that is visible, by how many others are.

    In an outage few are detected or none: of N expected n then have a probability of
    q^n (1 - q)^(N - n) instead of p^n (1 - p)^(N - n), and to be missed as well says little.

    :param visible: (N,) probability that each can be seen.
    :param measured: (K,) tracks that are measured, ascending.
    :param p: probability that one is, where there is no outage.
    """
    sure = visible > SURE
    hits = int(np.count_nonzero(sure[np.unique(measured)]))
    misses = max(int(np.count_nonzero(sure)) - 1 - hits, 0)
    log_odds = hits * math.log(DIM / p) + misses * math.log((1 - DIM) / (1 - p))
    outage = 1 / (1 + math.exp(min(-log_odds, 700.0)) * (1 - OUTAGE) / OUTAGE)
    return outage * (1 - DIM) + (1 - outage) * (1 - p)


def _learn_disappearances(
    prediction: Prediction,
    pairs: Hypotheses,
    learned: Adaptation,
    period: float,
    *,
    again: bool,
) -> None:
    """Note who has come back, and tell hidden from gone of those just lost."""
    records, unmeasured = prediction.records, prediction.unmeasured
    back = pairs.track[unmeasured[pairs.track] > LOST * period]
    if len(back):
        learned.disappearances.learn(records['seen'][back], returned=True)
    recent = (unmeasured > 0) & (unmeasured < JUST_LOST * period)
    recent[pairs.track] = False
    lost = recent.nonzero()[0]
    if len(lost) and not again:
        share = learned.disappearances.share(records['seen'][lost], learned.area)
        records['visible'][lost], records['hidden'][lost] = weigh_hidden(
            records['visible'][lost], records['hidden'][lost], share
        )


def _update_sizes(
    tracks: TrackTable[Bank],
    prediction: Prediction,
    blobs: Measurements,
    taken: Hypotheses,
    period: float,
) -> Bools:
    """Learn sizes from blobs that tracks have for themselves; return (K,) which are whole.

    While an object grows into view its centroid moves at half its speed.
    """
    track, blob, records = taken.track, taken.blob, tracks.records
    if not prediction.sized:
        return np.ones(len(track), bool)
    extent = records['extent'][track]
    alone = (np.bincount(blob, minlength=1)[blob] == 1) & ~blobs.joined[blob]
    excess = difference(total(extent), blobs.size[blob])
    now = learn_extents(prediction, blobs, taken, extent, excess, period)
    if np.count_nonzero(alone) < len(alone):
        now[~alone] = extent[~alone]
    records['extent'][track] = now
    whole = alone & (excess[:, 0] == 0) & (excess[:, 1] == 0)
    if np.count_nonzero(records['partial']):
        records['partial'][track] &= blobs.cut[blob] | ~whole[:, None]
    if np.count_nonzero(whole) < len(whole):
        size = total(extent)
        growth = total(now) - size
        growth[growth < slack(size)] = 0.0
        tracks.filters.doubt_velocity(track, (growth / 2 / period) ** 2)
    return np.asarray(whole)


def learn_extents(
    prediction: Prediction,
    blobs: Measurements,
    taken: Hypotheses,
    extent: Floats,
    excess: Floats,
    period: float,
) -> Floats:
    """The extents after these blobs, (K, 2, 2): whole ones are followed, others looked at.

    :param extent: (K, 2, 2) before them [px].
    :param excess: (K, 2) of the blobs' sizes, see difference() [px].
    """
    reach = blobs.reach(taken.blob)
    now = extent + FOLLOWING_SHARE * (reach - extent)
    one = ((excess[:, 0] != 0) | (excess[:, 1] != 0)).nonzero()[0]
    if len(one):
        track, blob, records = taken.track[one], taken.blob[one], prediction.records
        extent, last = extent[one], np.stack([records['box_w'], records['box_h']], axis=1)[track]
        center = centers(blobs.z[blob], blobs.box[blob], extent)
        expected = prediction.center[track]
        way = farthest(prediction, track) * period
        now[one] = learn(extent, reach[one], excess[one], center, expected, last, way, period)
    return now


def farthest(prediction: Prediction, track: Indices) -> Floats:
    """Speed of tracks, (K,), and twice its standard deviation [px/s]."""
    cov = prediction.bank.estimate()[1]
    variance = cov[track, 2, 2] + cov[track, 3, 3]
    return np.asarray(np.hypot(*prediction.velocity[track].T) + 2 * np.sqrt(variance))


def _learn(
    learned: Adaptation,
    prediction: Prediction,
    blobs: Measurements,
    taken: Hypotheses,
    whole: Bools,
    config: TrackerConfig,
    period: float,
) -> None:
    """Learn from what was measured, noise and motion from objects seen whole."""
    records, track, blob = prediction.records, taken.track, taken.blob
    if not len(track):
        return
    unmeasured, maneuvered = prediction.unmeasured[track], taken.innovations.maneuvered
    steady = whole & (unmeasured <= period)
    if np.count_nonzero(blobs.cut):
        steady &= ~blobs.cut[blob].any(axis=1)
    known = records['hits'][track] > FORMED_VELOCITY
    learned.learn_speed(known & steady, prediction.velocity[track], period)
    variance = blobs.mean_variance[blob]
    due = learned.recent.take(
        records, track, blobs.z[blob], variance / blobs.factor[blob], variance, unmeasured,
        maneuvered, steady, period,
    )  # fmt: skip
    if due and config.detection_covariance:
        prediction.bank.doubt(track, learned.noisiness.learn(records, track, learned.recent))
    if due and not config.process_noise:
        learned.unsteadiness.learn(records, track, learned.recent, period)
