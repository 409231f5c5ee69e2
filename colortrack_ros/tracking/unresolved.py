"""Unresolved measurements: one detection of several objects that are too close to be resolved.

Without boxes (see merge_split) a merged detection shows by its position: it lies at the mean of
objects that would otherwise be missed (Koch and van Keuk 1997). Their tracks coast, because the
objects are not seen one by one. They certainly exist, though, and are held to this mean.
"""

from typing import NamedTuple

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.existence import update_existence
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.estimation.innovations import compare
from colortrack_ros.estimation.track_table import marked
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.flicker import take_back_misses
from colortrack_ros.tracking.hypotheses import Association
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.hypotheses import hypothesize
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.rectangles import points_inside
from colortrack_ros.tracking.rectangles import runs
from colortrack_ros.tracking.resolution import Resolution
from colortrack_ros.tracking.splinters import find_hosts
from colortrack_ros.tracking.splinters import leave_out_splinters
from colortrack_ros.tracking.turns import UNLIKELY
from colortrack_ros.tracking.update import MOST_LOG_RATIO

MOST_MERGED, MOST_NEAR = 4, 8
"""Most objects in one detection, and most candidates for it, to bound the time. Assumed."""

SIGMAS = 3.0
"""Margin of a candidate beyond the resolution, in standard deviations of its predicted position:
99.7 % on an axis."""


class Shared(NamedTuple):
    """S sets of tracks that share blobs; no two have a track or a blob in common.

    :param member: (S, MOST_MERGED) tracks, -1 after the last.
    :param blob: (S,) blob shared by each set.
    :param gain: (S,) log-likelihood ratio of the set against the association without it.
    :param visible: (N,) of all tracks: probability before the frame that the object is visible.
    :param hidden: (N,) probability before the frame that it exists and is not.
    """

    member: Indices
    blob: Indices
    gain: Floats
    visible: Floats
    hidden: Floats


def share_centroids(
    prediction: Prediction, blobs: Measurements, associated: Association, resolution: Resolution
) -> tuple[Association, Shared | None]:
    """Find missed tracks that share a blob at the mean of their predictions.

    :param resolution: how close objects have to be to merge; updated here.
    :return: the association without the pairs of tracks that share, and without their blobs among
        the free ones; and those tracks, None if there are none, with boxes, or with soft decisions.
    """
    records, pairs = prediction.records, associated.pairs
    if prediction.sized or not len(records) or not associated.hard:
        return associated, None
    host = find_hosts(prediction, resolution.reach)
    sure = records['state'] != TENTATIVE
    resolved = blobs.z[pairs.blob[sure[pairs.track]]]
    missed = sure & (prediction.unmeasured > 0)
    # An object counts as merged no longer than it was seen before: if brief, it may be a piece.
    forgotten = prediction.unseen > records['hits'] * prediction.step.period
    records['shared'][forgotten] = 0
    missed &= ~forgotten
    missed[pairs.track] = False
    shared = None
    if np.count_nonzero(missed) and len(blobs):
        shared = _choose(prediction, blobs, associated, missed, resolution)
    if shared is None:
        resolution.learn(resolved, resolved[:0, 0])
        return associated, None
    kept = ~marked(shared.member, len(records) + 1)[pairs.track]  # the row beyond is that of -1
    kept &= ~marked(shared.blob, len(blobs))[pairs.blob]
    rest = pairs.take(kept.nonzero()[0])
    free = associated.free.copy()
    free[shared.blob] = False
    shared, whole = _leave_out_splinters(prediction, blobs, shared, host)
    nearest = _nearest(prediction, shared.member)
    resolution.learn(resolved, nearest[nearest > 0])
    rest.extend(whole)
    rest = rest.take(rest.track.argsort())
    return Association(rest, np.ones(len(rest)), free, True), shared if len(shared.blob) else None


def _leave_out_splinters(
    prediction: Prediction, blobs: Measurements, shared: Shared, host: Indices
) -> tuple[Shared, Hypotheses]:
    """Remove splinters from the sets; if that leaves a single object, its blob is no longer shared.

    :param host: (N,) see splinters.find_hosts().
    :return: the sets that still share a blob, and hypotheses for the single objects.
    """
    member = leave_out_splinters(prediction.records, shared.member, host)
    several, alone = ((member[:, 1] >= 0) == some for some in (True, False))
    track, blob = member[alone, 0], shared.blob[alone]
    order = track.argsort()
    left = (member[several], shared.blob[several], shared.gain[several])
    whole = hypothesize(prediction, blobs, track[order], blob[order])
    return Shared(*left, shared.visible, shared.hidden), whole


def _choose(
    prediction: Prediction,
    blobs: Measurements,
    associated: Association,
    missed: Bools,
    resolution: Resolution,
) -> Shared | None:
    """Choose the best sets; None if there are none.

    :param missed: (N,) which tracks have no blob.
    """
    records, pairs = prediction.records, associated.pairs
    owner, worth = np.full(len(blobs), -1), np.zeros(len(blobs))
    sure = records['state'][pairs.track] != TENTATIVE
    owner[pairs.blob] = np.where(sure, pairs.track, -1)
    worth[pairs.blob] = pairs.innovations.log_likelihood + prediction.log_odds[pairs.track]
    worth[pairs.blob] -= prediction.log_density
    track, blob = _find_candidates(prediction, blobs, missed, owner, resolution.reach)
    if len(track) < 2:
        return None
    member, blob = _list_sets(track, blob, owner)
    if not len(member):
        return None
    gain = _compare(prediction, blobs, member, blob) - worth[blob]
    gain += resolution.log_chance(_nearest(prediction, member)).sum(axis=1)
    left = np.argsort(-gain, kind='stable')[: np.count_nonzero(gain > 0)]
    chosen = []
    while len(left):
        best = left[0]
        chosen.append(best)
        mine = member[best][member[best] >= 0]
        others = ~(member[left][:, :, None] == mine).any(axis=(1, 2))
        left = left[others & (blob[left] != blob[best])]
    if not chosen:
        return None
    before = records['visible'].copy(), records['hidden'].copy()
    return Shared(member[chosen], blob[chosen], gain[chosen], *before)


def _find_candidates(
    prediction: Prediction, blobs: Measurements, missed: Bools, owner: Indices, reach: float
) -> tuple[Indices, Indices]:
    """Return candidate tracks, (K,), and the blobs they may share, (K,), ascending by blob.

    These are the owner of each blob, first, and the missed tracks nearby.

    :param missed: (N,) which tracks have no blob.
    :param owner: (M,) track of each blob, -1 for none.
    :param reach: largest distance of a track from the blob that it shares [px].
    """
    missing = missed.nonzero()[0]
    half = reach + SIGMAS * np.sqrt(prediction.variance[missing])
    one, blob = points_inside(prediction.center[missing], half, blobs.z, MOST_NEAR)
    track = missing[one]
    same = (prediction.records['color'][track] == blobs.rows['color'][blob]).nonzero()[0]
    track, blob = track[same], blob[same]
    if not len(track):
        return track, blob
    away = prediction.center[track] - blobs.z[blob]
    owned = np.unique(blob)
    owned = owned[owner[owned] >= 0]
    track, blob = np.append(owner[owned], track), np.append(owned, blob)
    order = np.lexsort((np.append(np.full(len(owned), -1.0), (away * away).sum(axis=1)), blob))
    track, blob = track[order], blob[order]
    rank = np.arange(len(blob)) - blob.searchsorted(blob)
    near = rank < MOST_NEAR
    return track[near], blob[near]


def _list_sets(track: Indices, blob: Indices, owner: Indices) -> tuple[Indices, Indices]:
    """List all sets of two to MOST_MERGED candidates of a blob, with its owner if it has one.

    :param track, blob: (K,) candidates, ascending by blob.
    :return: (S, MOST_MERGED) tracks, -1 after the last, and (S,) the blob of each set.
    """
    end = blob.searchsorted(blob, side='right')
    place = np.arange(len(blob))
    alone = (owner[blob] < 0) | (owner[blob] == track)
    member = place[alone, None]
    sets: list[Indices] = []
    for size in range(2, MOST_MERGED + 1):
        last = member[:, -1]
        which, following = runs(last + 1, end[last] - last - 1)
        member = np.concatenate([member[which], following[:, None]], axis=1)
        sets.append(np.full((len(member), MOST_MERGED), -1))  # np.pad takes longer than all of this
        sets[-1][:, :size] = member
    together = np.concatenate(sets)
    return np.where(together >= 0, track[together], -1), blob[together[:, 0]]


def _nearest(prediction: Prediction, member: Indices) -> Floats:
    """Return distances of all members but one to their nearest neighbors, (S, MOST_MERGED), else 0.

    :param member: (S, MOST_MERGED) tracks, -1 after the last.
    """
    center = prediction.center[member]
    apart = center[:, :, None] - center[:, None]
    d2 = (apart * apart).sum(axis=3)
    none = member < 0
    d2[none[:, :, None] | none[:, None] | np.eye(member.shape[1], dtype=bool)] = np.inf
    nearest = np.sqrt(np.where(none, 0.0, d2.min(axis=2, initial=np.inf)))
    nearest.sort(axis=1)
    nearest[:, -1] = 0.0
    return nearest


def _measure(
    bank: Bank, blobs: Measurements, member: Indices, blob: Indices
) -> tuple[Indices, Indices, Floats, Floats]:
    """Return what shared blobs measure of each member: n times the centroid, less the others.

    If the filters are independent, its effect on each of them is that of measuring the mean.

    :return: (K,) set and (K,) track of each member, (K, 2) position and its covariance (K, 2, 2).
    """
    mean, cov = bank.estimate()
    some = member >= 0
    name, place = some.nonzero()
    track, n, at = member[name, place], some.sum(axis=1)[name], blob[name]
    center, P = mean[track, :2], cov[track, :2, :2]
    total, spread = np.zeros((len(member), 2)), np.zeros((len(member), 2, 2))
    np.add.at(total, name, center)
    np.add.at(spread, name, P)
    z = n[:, None] * blobs.z[at] - (total[name] - center)
    return name, track, z, n[:, None, None] ** 2 * blobs.R[at] + (spread[name] - P)


def _compare(prediction: Prediction, blobs: Measurements, member: Indices, blob: Indices) -> Floats:
    """Return the log-likelihood ratios of sets, (S,), against missed tracks and a free blob.

    One of the members may have maneuvered.
    """
    name, track, z, R = _measure(prediction.bank, blobs, member, blob)
    chance, T = prediction.maneuvered[track], prediction.unmeasured[track]
    compared = compare(prediction.bank, track, z, R, chance, T, prediction.turn_speed(track))
    gain = np.full(len(member), -np.inf)
    np.maximum.at(gain, name, compared.log_likelihood)
    gain += 2 * np.log((member >= 0).sum(axis=1)) - prediction.log_density
    np.add.at(gain, name, prediction.log_odds[track])
    return gain


def follow_shared(
    tracks: TrackTable[Bank], shared: Shared, prediction: Prediction, blobs: Measurements
) -> None:
    """Update tracks by the blobs they share, after all others have been updated.

    At most one member of a set has maneuvered; the innovations weigh which.
    """
    records, bank = tracks.records, tracks.filters
    name, track, z, R = _measure(bank, blobs, shared.member, shared.blob)
    log_ratio = np.minimum(shared.gain[name] - prediction.log_odds[track], MOST_LOG_RATIO)
    records['visible'][track], records['hidden'][track] = update_existence(
        shared.visible[track], shared.hidden[track], np.exp(log_ratio)
    )
    if not prediction.step.pauses:  # of what they share one is always seen
        first = track[records['shared'][track] < prediction.step.now]
        take_back_misses(records, first, prediction.unmeasured, prediction.step.period)
    records['shared'][track] = prediction.step.now
    if bank.model.selected:
        return
    chance, T = prediction.maneuvered[track], prediction.unmeasured[track]
    compared = compare(bank, track, z, R, chance, T, prediction.turn_speed(track))
    odds = compared.maneuvered / np.maximum(1 - compared.maneuvered, TINY)
    chance = odds / (1 + np.bincount(name, odds)[name])
    turned = (chance > UNLIKELY).nonzero()[0]
    if len(turned):
        bank.maneuver(
            track[turned], chance[turned], T[turned], prediction.turn_speed(track[turned])
        )
        _, _, z, R = _measure(bank, blobs, shared.member, shared.blob)
    order = track.argsort()
    bank.correct(track[order], z[order], R[order])
