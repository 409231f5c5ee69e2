"""Crossings: deferred decisions on tracks that may have exchanged their detections.

Where two objects come so close that either may have caused the other's detection, a decision in
that frame is a guess. For these tracks alone it is deferred: their previous predictions are kept,
and once they have separated, lines through their next detections tell which is which
(track-oriented multiple hypotheses, pruned N scans later; Blackman 2004).
"""

import math

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.motion.constant_velocity import REFERENCE_PERIOD
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import rows_of
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.hidden_rivals import remember_hidden
from colortrack_ros.tracking.hidden_rivals import rivals
from colortrack_ros.tracking.hypotheses import Association
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.lines import add_to_lines
from colortrack_ros.tracking.lines import coasted
from colortrack_ros.tracking.lines import fit_lines
from colortrack_ros.tracking.maneuvers import maneuver_chance
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.sizes import Sizes
from colortrack_ros.tracking.stitching import log_likelihood_ratio

DOUBTFUL = math.log(1000)
"""Exchanges of detections less likely than one in a thousand are ruled out. Assumed."""

SCANS = 6
"""Detections after the separation that may decide. The velocity of their line is known to
sqrt(12 / (6 * 35)) = 0.24 standard deviations of a detection a frame. Assumed: more take longer."""

CLEAR = math.log(99)
"""Log-likelihood ratio at which one decision in a hundred is wrong, as in the sequential test of
Wald 1945. Until then the test is repeated with each detection."""

MOST_SCANS = 3 * SCANS
"""Detections after which a decision is forced. Assumed; with 12, of 192 pairs that cross at 5
degrees, 8 are exchanged instead of 3."""

ESTABLISHED = 10
"""Hits from which the direction of a track is reliable. Assumed."""

UNSTEADY = 0.1
"""Probability of a maneuver since the meeting from which lines cannot tell the two apart: the
frame-by-frame decisions stand unless sizes contradict them. Assumed: one of the two has then
maneuvered in a fifth of the cases."""

OWN = ('track_id', 'born', 'origin', 'color', 'hits', 'gaps', 'host', 'farthest')
"""Fields that a track keeps when it exchanges its state with another."""


def defer(
    hypotheses: Hypotheses,
    gain: Floats,
    associated: Association,
    prediction: Prediction,
    blobs: Measurements,
) -> None:
    """Remember pairs of tracks that might just as well have each other's detections.

    :param hypotheses, gain: K pairs, of which some were chosen, and their scores.
    :param associated: the chosen ones; soft decisions do not need to be deferred.
    """
    if len(hypotheses.track) == len(associated.pairs.track):
        return
    if associated.hard:
        one, other = _find_rivals(hypotheses, gain, associated, prediction, blobs)
        if len(one):
            _remember(prediction, one, other)


def _find_rivals(
    hypotheses: Hypotheses,
    gain: Floats,
    associated: Association,
    prediction: Prediction,
    blobs: Measurements,
) -> tuple[Indices, Indices]:
    """Find pairs of tracks that might just as well have each other's detections.

    With sizes, two tracks on one blob are handled elsewhere (see merged), and sizes count with the
    weight that they will have when the decision is made. Without sizes, a track without a blob may
    have that of the other.

    :return: (P,) and (P,) tracks, each the other's nearest rival; both ways round.
    """
    track, blob, pairs = hypotheses.track, hypotheses.blob, associated.pairs
    width, count, sized = len(blobs), len(prediction.records), prediction.sized
    owner, taken = np.zeros(width, np.intp) - 1, np.zeros(count, np.intp) - 1
    owner[pairs.blob], taken[pairs.track] = pairs.track, pairs.blob
    worth = np.zeros(count)
    chosen = taken[track] == blob
    worth[track[chosen]] = gain[chosen]
    cross = (~chosen & (owner[blob] >= 0)).nonzero()[0]
    if sized:
        cross = cross[taken[track[cross]] >= 0]
    one, other = track[cross], owner[blob[cross]]
    loss = worth[one] + worth[other] - gain[cross]
    if sized:
        loss += (SCANS - 1) * _fit_better(prediction, blobs, one, other, taken)
    near = loss - worth[one] < DOUBTFUL
    one, other, loss = one[near], other[near], loss[near]
    if not len(one):
        return one, other
    loss -= np.where(taken[one] >= 0, _gain_of(hypotheses, gain, other, taken[one], width), 0.0)
    return _mutual(np.append(one, other), np.append(other, one), np.append(loss, loss), count)


def _gain_of(
    hypotheses: Hypotheses, gain: Floats, track: Indices, blob: Indices, width: int
) -> Floats:
    """Gains of pairs of a track and one of so many blobs, (P,); -inf for what is no hypothesis."""
    key = hypotheses.track * width + hypotheses.blob
    order, wanted = key.argsort(), track * width + blob
    place = order[np.minimum(key[order].searchsorted(wanted), len(key) - 1)]
    return np.where(key[place] == wanted, gain[place], -np.inf)


def _fit_better(
    prediction: Prediction, blobs: Measurements, one: Indices, other: Indices, taken: Indices
) -> Floats:
    """Log-likelihood ratio of the sizes, (P,), of pairs that have their blobs against exchanged.

    :param taken: (N,) the blob of each track.
    """
    ours, theirs = blobs.size.take(taken[one], axis=0), blobs.size.take(taken[other], axis=0)
    size, track = np.concatenate([ours, theirs, theirs, ours]), np.concatenate([one, other] * 2)
    fit = prediction.log_fit(track, size).reshape(4, len(one))
    return np.asarray((fit[0] - fit[2]) + (fit[1] - fit[3]))


def _mutual(one: Indices, other: Indices, loss: Floats, count: int) -> tuple[Indices, Indices]:
    """Pairs of tracks that are each other's rival of least loss, below DOUBTFUL."""
    rival, order = np.full(count, -1), np.argsort(-loss, kind='stable')
    order = order[loss[order] < DOUBTFUL]
    rival[one[order]] = other[order]
    mutual = np.flatnonzero((rival >= 0) & (rival[rival] == np.arange(count)))
    return mutual, rival[mutual]


def _remember(prediction: Prediction, one: Indices, other: Indices) -> None:
    """Record rivals, (P,) and (P,), both ways round, and their predictions when they met."""
    records, stamp = prediction.records, prediction.step.now
    fit = (records['state'] != TENTATIVE) & (records['hits'] >= ESTABLISHED)
    fit = fit[one] & fit[other]
    ids = records['track_id']
    _, free = rivals(records)
    new = fit & free[one] & free[other]
    mean, cov = prediction.bank.estimate()
    fresh = one[new]
    records['rival'][fresh] = ids[other[new]]
    records['met'][fresh] = stamp
    records['before_size'][fresh] = prediction.size[fresh]
    records['before'][fresh], records['before_cov'][fresh] = mean[fresh, :4], cov[fresh, :4, :4]
    again = one[records['rival'][one] == ids[other]]
    records['apart'][again] = stamp
    records['sums'][again] = records['scans'][again] = records['size_log_ratio'][again] = 0


def tell_apart(
    tracks: TrackTable[Bank],
    pairs: Hypotheses,
    prediction: Prediction,
    config: TrackerConfig,
) -> None:
    """Add the measurements of rivals to their lines, and exchange those that were confused.

    :param pairs: the measurements of this frame.
    """
    records, stamp = tracks.records, prediction.step.now
    rival = records['rival']
    if pairs.track.size < rival.size and prediction.sized and not prediction.step.pauses:
        remember_hidden(records, prediction, SCANS)
    if not np.count_nonzero(rival):
        return
    add_to_lines(records, pairs, stamp)
    if prediction.sized:
        _sum_up_sizes(records, pairs.track, prediction.sizes, stamp)
    one, other = _ready(records, stamp, config.max_hidden)
    if not len(one):
        return
    since = (stamp - records['met'][one]) / NANOSECONDS
    chance = config.maneuvers * maneuver_chance(records['rate'][one], since)
    ratio = _compare(records, one, other, chance, prediction, stamp)
    steady = chance < UNSTEADY
    ratio *= steady
    sizes, says_nothing = _ratio_of_sizes(records['size_log_ratio'], one, other), ratio == 0
    ratio += sizes
    says_nothing &= records['size_log_ratio'][one] == 0
    scans = np.minimum(records['scans'][one], records['scans'][other])
    decided = (np.abs(ratio) > CLEAR) | (scans >= MOST_SCANS) | says_nothing
    exchanged = (ratio < np.where(steady, 0.0, -CLEAR))[decided]
    one, other = one[decided], other[decided]
    if np.count_nonzero(exchanged):
        _exchange(tracks, one[exchanged], other[exchanged])
    records['rival'][one] = records['rival'][other] = 0


def _ready(records: Records, stamp: int, patience: float) -> tuple[Indices, Indices]:
    """Rivals, (P,) and (P,), that have both been measured often enough since they separated.

    :param patience: time after which a rival that is gone is forgotten [s].
    """
    one = records['rival'].nonzero()[0]
    other, gone = (column[one] for column in rivals(records))
    late = (stamp - records['met'][one]) / NANOSECONDS > patience
    records['rival'][one[gone & late]] = 0
    scans = np.minimum(records['scans'][one], records['scans'][other])
    ready = ~gone & (one < other) & (scans >= SCANS)
    return one[ready], other[ready]


def _sum_up_sizes(records: Records, track: Indices, sizes: Sizes, stamp: int) -> None:
    """Add what the sizes of the last detections of separated rivals say about who they are.

    What is learned of sizes has followed the decisions that are in doubt, so it is not used.

    :param track: (K,) which were measured.
    """
    mine = track[(records['rival'][track] > 0) & (records['apart'][track] < stamp)]
    theirs, there = rows_of(records, records['rival'][mine])
    mine, theirs = mine[there], theirs[there]
    size = records['box_size'][mine]
    own, other = (sizes.log_fit(records['before_size'][rows], size) for rows in (mine, theirs))
    records['size_log_ratio'][mine] += own - other


def _ratio_of_sizes(each: Floats, one: Indices, other: Indices) -> Floats:
    """Log-likelihood ratio of the sizes of rivals, (P,): negative only if both say so.

    Of two that have grown since, as before a robot that drives, the small one may look as the large
    one did, but not the large one as the small one did.

    :param each: (N,) of each track, own over rival's.
    """
    both = each[one] + each[other]
    return np.where(np.maximum(each[one], each[other]) < 0, both, np.maximum(both, 0.0))


def _compare(
    records: Records,
    one: Indices,
    other: Indices,
    chance: Floats,
    prediction: Prediction,
    stamp: int,
) -> Floats:
    """Log-likelihood ratio of lines, (P,): pairs as they are against exchanged."""
    both, count = np.append(one, other), len(one)
    mean, cov = records['before'][both], records['before_cov'][both]
    T = (stamp - records['met'][both]) / NANOSECONDS
    mean, cov = coasted(mean, cov, T, prediction.noise**2 * REFERENCE_PERIOD)
    lines, of_lines = fit_lines(records, both, stamp)
    mean, cov = np.append(mean, lines, axis=0), np.append(cov, of_lines, axis=0)
    k = np.arange(2 * count)
    line = 2 * count + np.append(k, np.roll(k, count))  # as they are, and exchanged
    both, chance, T = np.tile(k, 2), np.tile(chance, 4), np.tile(T, 2)
    ratio = log_likelihood_ratio(mean, cov, both, line, chance, T, prediction.speed)
    own, exchanged = ratio.reshape(2, 2, count)
    return np.asarray((own - exchanged).sum(axis=0))


def _exchange(tracks: TrackTable[Bank], one: Indices, other: Indices) -> None:
    """Exchange the states of tracks, all but their OWN fields."""
    into, out = np.append(one, other), np.append(other, one)
    tracks.filters.put(into, tracks.filters.take(out))
    records = tracks.records
    own = {name: records[name][into] for name in OWN}
    records.put(into, records.take(out))
    for name in OWN:
        records[name][into] = own[name]
