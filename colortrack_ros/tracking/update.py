"""Update: filters, existence and sizes of tracks by their measurements."""

import math

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.box_centers import lasting_variance
from colortrack_ros.estimation.existence import update_existence
from colortrack_ros.estimation.existence import weigh_hidden
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import marked
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.disappearances import LOST
from colortrack_ros.tracking.edges import doubt_covered
from colortrack_ros.tracking.extents import update_extents
from colortrack_ros.tracking.flicker import JUST_LOST
from colortrack_ros.tracking.flicker import MISSES_COUNT
from colortrack_ros.tracking.flicker import take_back_misses
from colortrack_ros.tracking.hypotheses import Association
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.measurements import by_axis
from colortrack_ros.tracking.measurements import mean_of_axes
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.recent import EVERY
from colortrack_ros.tracking.records import record_size
from colortrack_ros.tracking.second_difference import learn_acceleration
from colortrack_ros.tracking.traffic import leaving_rate
from colortrack_ros.tracking.turns import UndecidedTurns
from colortrack_ros.tracking.turns import UNLIKELY

SINCE = (((np.arange(5) + 0.5) / 5) ** 2)[:, None, None]
"""Times since a maneuver over T, by the midpoint rule in their square roots: recent ones, which
show least, are sampled most densely. With 12 instead of 5 the NEES of turns changes by < 0.05."""

SHARE = 2 * np.sqrt(SINCE[:, 0]) / len(SINCE)
"""Weights of these times, from the derivative of the square."""

MOST_LOG_RATIO = 50.0
"""Bound of a log-likelihood ratio that keeps its exponential finite; exp(50) leaves no doubt."""

OUTAGE, DIM = 0.01, 0.1
"""Probability that the camera or the detector fails in a frame, and that an object is detected
nevertheless. Assumed: one frame in 3 s, and one object in ten."""

MISSED_DIM, NO_OUTAGE_ODDS = 1 - DIM, (1 - OUTAGE) / OUTAGE
"""Probability that an object is missed in an outage, and the odds against one."""

SURE = 0.9
"""Least probability of being visible of the tracks that indicate an outage: tentative tracks on
clutter, which is detected once, would indicate one in every frame. Assumed."""

FORMED_VELOCITY = 2
"""Hits after which the velocity has been measured (two-point differencing), so that innovations say
something about the motion."""


def update(
    tracks: TrackTable[Bank],
    prediction: Prediction,
    blobs: Measurements,
    associated: Association,
    learned: Adaptation,
    turns: UndecidedTurns,
    config: TrackerConfig,
) -> None:
    """Update filters, existence and sizes, and learn from the frame."""
    pairs, probability = associated.pairs, associated.probability
    measured = marked(pairs.track, len(prediction.center))
    _update_existence(prediction, pairs, measured)
    _learn_disappearances(prediction, pairs, measured, learned)
    taken = pairs if associated.hard else pairs.take(np.flatnonzero(probability > 0.5))
    whole, odd = update_extents(tracks, prediction, blobs, taken)
    whole |= learned.overlaps.are_resolved
    if not prediction.step.again:
        _learn(learned, prediction, blobs, taken, whole, config)
    every = len(taken) == len(prediction.center)  # whether all are measured
    _unsettle(tracks.records, prediction, taken, every=every)
    if config.acceleration_span:
        learn_acceleration(
            tracks.records, taken.track[whole], taken.z[whole], prediction.step.now,
            config.acceleration_span,
        )  # fmt: skip
    turns.correct(prediction, associated, taken, learned, config)
    if odd is not None:
        doubt_covered(prediction, blobs, taken.take(odd))
    if learned.maneuvers.is_due(prediction.step.now):
        variance = (taken.R[whole, 0, 0] + taken.R[whole, 1, 1]) / 2
        learned.maneuvers.learn(
            tracks.records, taken.track[whole], taken.z[whole], variance,
            *tracks.filters.estimate(), prediction.step.now, prediction.speed,
        )  # fmt: skip
    _record_hits(tracks, taken, blobs, prediction, learned, every=every)


def _record_hits(
    tracks: TrackTable[Bank],
    taken: Hypotheses,
    blobs: Measurements,
    prediction: Prediction,
    learned: Adaptation,
    *,
    every: bool,
) -> None:
    """Record which tracks were measured, where, and their sizes.

    In a pause of the detector nothing is missed. A blob of several objects says nothing about the
    size of each: they keep theirs.
    """
    records = tracks.records
    track = slice(None) if every else taken.track
    step, unmeasured = prediction.step, prediction.unmeasured
    if step.again and not step.pauses:
        take_back_misses(records, track, unmeasured, step.period)
    elif not (every or step.pauses):
        for name, frames in MISSES_COUNT:
            missed = unmeasured < frames * step.period
            missed[track] = False
            records[name] += missed
    tracks.record_hits(track, step.now)
    records['seen'][track] = taken.z
    blob, z = taken.blob, taken.z
    systematic = blobs.systematic.take(blob, axis=0)
    lasting = learned.noisiness.boxes.lasting[learned.overlaps.are_estimated]
    if lasting:
        size = blobs.size.take(blob, axis=0) * (blobs.rows['cov_uu'].take(blob) == 0)[:, None]
        systematic += lasting * lasting_variance(size)
    records['systematic'][track] = systematic
    if np.count_nonzero(blobs.mixed):
        alone = np.bincount(blob)[blob] == 1
        track, blob, z = taken.track[alone], blob[alone], z[alone]
    record_size(records, track, blobs.rows.take(blob), z)


def _unsettle(records: Records, prediction: Prediction, taken: Hypotheses, *, every: bool) -> None:
    """Record what maneuvers ignored by the filters add to the covariance of the velocity.

    A maneuver at the end of a frame has hardly moved the object yet, so the measurement cannot rule
    it out. At a time s before the measurement, s uniformly distributed over T, it draws a new
    velocity from N(0, speed^2). Per axis, with the innovation e and its variance S without a
    maneuver::

        e ~ N(-v s, S + speed^2 s^2)    g = speed^2 s / (S + speed^2 s^2)
        v' = g (e + v s)                var v' = speed^2 (1 - g s)
    """
    rows = slice(None) if every else taken.track
    if not (every or prediction.step.again):
        records['unsettled'] = 0.0
    speed = prediction.turn if every else prediction.turn_speed(taken.track)
    variance = speed.T**2
    s = SINCE * prediction.unmeasured[rows]
    v = prediction.velocity[rows].T.copy()
    e = np.subtract(taken.z.T, prediction.center[rows].T, order='C')
    S = np.add(prediction.variance[rows].T, by_axis(taken.R).T, order='C')
    with_position = variance * s
    wide = with_position * s + S
    aside = v * s + e
    d2 = e * e / S - aside * aside / wide
    weight = SHARE * np.exp(np.minimum(np.add.reduce(d2, axis=1) / 2.0, MOST_LOG_RATIO))
    weight *= np.sqrt(np.multiply.reduce(S / wide, axis=1))
    gain = with_position / wide
    change = gain * aside - v
    of_axes = weight[:, None]
    weighted = of_axes * change
    uu, vv = np.add.reduce(weighted * change + of_axes * (variance - gain * with_position))
    uv = np.add.reduce(weighted[:, 0] * change[:, 1])
    chance = prediction.maneuvered[rows] * (taken.innovations.maneuvered <= UNLIKELY)
    chance /= 1.0 - chance + chance * np.add.reduce(weight)
    records['unsettled'][rows] = (chance * np.array([uu, uv, uv, vv])).T.reshape(-1, 2, 2)


def _update_existence(prediction: Prediction, pairs: Hypotheses, measured: Bools) -> None:
    """Update existence by the likelihood of measurements or misses (Musicki et al. 1994).

    :param measured: (N,) which tracks are in the pairs.
    """
    p, records = prediction.detection_probability, prediction.records
    visible = records['visible']
    step = prediction.step
    missed = 1.0 if step.again or step.pauses else _missed(visible, measured, p)
    log_ratio = pairs.innovations.log_likelihood - prediction.log_density
    found = p * np.exp(np.minimum(log_ratio, MOST_LOG_RATIO))
    ratio = np.add(missed, np.bincount(pairs.track, found, len(visible)), dtype=np.float64)
    records['visible'], records['hidden'] = update_existence(visible, records['hidden'], ratio)


def _missed(visible: Floats, measured: Bools, p: float) -> float:
    """Probability of missing a visible object, given how many others are missed.

    In an outage few objects are detected, or none: n of N detected then have the likelihood
    q^n (1 - q)^(N - n) instead of p^n (1 - p)^(N - n), and one more miss says little.

    :param visible: (N,) probability that each is visible.
    :param measured: (N,) which are measured.
    :param p: detection probability where there is no outage.
    """
    sure = visible > SURE
    hits = np.count_nonzero(sure & measured)
    misses = max(np.count_nonzero(sure) - 1 - hits, 0)
    q = 1 - p
    log_ratio = hits * math.log(p / DIM)
    if misses:
        log_ratio += misses * math.log(q / MISSED_DIM)
    outage = 1 / (1 + math.exp(min(log_ratio, 700.0)) * NO_OUTAGE_ODDS)
    return outage * MISSED_DIM + (1 - outage) * q


def _learn_disappearances(
    prediction: Prediction, pairs: Hypotheses, measured: Bools, learned: Adaptation
) -> None:
    """Learn from objects that have reappeared, and split those just lost into hidden and gone."""
    records, unmeasured = prediction.records, prediction.unmeasured
    back = pairs.track[unmeasured[pairs.track] > LOST * prediction.step.period]
    if len(back):
        learned.disappearances.learn(records['seen'][back], unmeasured[back], returned=True)
    if prediction.step.again or np.count_nonzero(measured) == len(measured):
        return
    recent = (unmeasured > 0) & (unmeasured < JUST_LOST * prediction.step.period) & ~measured
    recent &= records['left'] <= records['updated']  # a known turn takes away, but hides nothing
    lost = recent.nonzero()[0]
    if len(lost):
        seen = records['seen'][lost]
        leaving = leaving_rate(seen, prediction.velocity[lost], learned.image_size)
        share = learned.disappearances.share(seen, learned.area, leaving=leaving)
        share[records['splinter'][lost]] = 0.0
        records['leaving'][lost], records['hidden_share'][lost] = leaving, share
        records['visible'][lost], records['hidden'][lost] = weigh_hidden(
            records['visible'][lost], records['hidden'][lost], share
        )


def _learn(
    learned: Adaptation,
    prediction: Prediction,
    blobs: Measurements,
    taken: Hypotheses,
    whole: Bools,
    config: TrackerConfig,
) -> None:
    """Learn from the measurements; noise and motion only from objects seen completely."""
    records, period = prediction.records, prediction.step.period
    track, blob = taken.track, taken.blob
    if not len(track):
        return
    maneuvered = taken.innovations.maneuvered
    unseen = prediction.unseen[track]
    if np.count_nonzero(blobs.cut):
        whole = whole & ~blobs.cut[blob].any(axis=1)
    steady = whole & (unseen <= period)
    known = records['hits'][track] > FORMED_VELOCITY
    learned.learn_speed(known & steady, prediction.velocity.take(track, axis=0), period)
    given = blobs.given.take(blob, axis=0)
    variance = mean_of_axes(blobs.variance.take(blob, axis=0))
    due = learned.recent.take(
        records, track, blobs.z.take(blob, axis=0), given, variance, unseen, maneuvered, whole,
        steady, blobs.size.take(blob, axis=0), period,
    )  # fmt: skip
    if due:
        _learn_more(learned, prediction, blobs, track, blob, config)


def _learn_more(
    learned: Adaptation,
    prediction: Prediction,
    blobs: Measurements,
    track: Indices,
    blob: Indices,
    config: TrackerConfig,
) -> None:
    """Learn what is not learned in every frame, from pairs, (K,)."""
    records, period = prediction.records, prediction.step.period
    if prediction.sized:
        last, size = records['box_size'][track], blobs.size[blob]
        # the size of a shared blob against the object's own would seem to be jitter
        again = (prediction.unseen[track] <= period) & ~blobs.mixed[blob]
        again &= (np.minimum(last, size) > 0).all(axis=1)
        learned.sizes.learn_jitter(last[again], size[again], EVERY * period)
    confirmed = track[records['state'][track] != TENTATIVE]
    learned.detection_rate.learn(prediction.unmeasured[confirmed] / period)
    if config.detection_covariance:
        predicted = mean_of_axes(prediction.variance.take(track, axis=0))
        grown = learned.noisiness.learn(records, track, learned.recent, predicted)
        prediction.bank.doubt(track, grown)
    if not config.process_noise:
        learned.unsteadiness.learn(records, track, learned.recent)
