"""Strays: detections that lie outside the gate of a track, and yet belong to it.

Noise is not normal, and changes: a light goes out, a detector meets another background. Velocities
are not normal either: among objects mostly at rest, one is suddenly pushed. If nothing fits a
settled track, and a detection fits no track, they are more likely one object than one that
disappeared just as another appeared (a second association among the rest, as in Zhang et al. 2022,
with the likelihood of a mixture of a narrow and a wide Gaussian, Tukey 1960).
"""

from dataclasses import replace
import math

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.gaussian import log_density
from colortrack_ros.tracking.association import ASSOCIATORS
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.gating import gate
from colortrack_ros.tracking.hypotheses import Association
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.hypotheses import hypothesize
from colortrack_ros.tracking.hypotheses import score
from colortrack_ros.tracking.maneuvers import FIRST_RATE
from colortrack_ros.tracking.maneuvers import maneuver_chance
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import LAST_FRAME
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.unresolved import Shared

Chosen = tuple[Hypotheses, Floats]
"""Hypotheses and the probability of each."""

STRAYING = 0.01
"""Probability that a detection strays. Assumed: that of an outage."""

STRAY_SPREAD = 5.0**2
"""Variance of strays over that of other detections. Assumed: with 10, single errors of 20 standard
deviations do not break tracks either, but turns pass for strays."""

SUDDEN = 0.1
"""Share of maneuvers with the rate and the speed assumed before any are seen (maneuvers.FIRST_RATE,
Adaptation.sudden_speed), whatever has been learned since. Assumed: with 1 the tracks of real cups
are the same."""

LEAP = 0.25
"""Standard deviation of the leaps of a blob's center from one frame to the next, as a share of its
size: what is seen of the object has changed, its hair, arms or light, or what covers it; it has not
been pushed. Half the size is then two of them. Assumed: 0.15 breaks the track of a figure that
jumps up and screams (benchmark/notes/tracker.md), 0.35 does not."""

LEAST_LEAP = 1e-9
"""Variance of leaps where the size is not known [px^2]: small enough that none is likely, and far
from where a determinant underflows."""

MOST_STRAYS, TURN_CHANCE = 2, 0.5
"""Strays on end that are further and further aside, after which the next one is of an object that
has turned, and the probability of that. Assumed: with 1, Student's noise with 3 degrees of freedom
passes for turns now and then (benchmark/notes/tracker.md)."""

SETTLED_HITS = 12
"""Hits after which the noise of a track is known: most of those that recent.RING keeps. Assumed."""


def take_strays(
    prediction: Prediction,
    blobs: Measurements,
    associated: Association,
    shared: Shared | None,
    config: TrackerConfig,
) -> Association:
    """Associate free blobs with settled tracks that have none, with the covariance of strays.

    :param shared: tracks that share a blob.
    :return: the association with these pairs added.
    """
    records, pairs = prediction.records, associated.pairs
    if len(pairs) >= len(records) or prediction.step.again:
        return associated
    free = associated.free.nonzero()[0]
    if not len(free):
        return associated
    missed = (records['state'] != TENTATIVE) & (records['hits'] >= SETTLED_HITS)
    missed[pairs.track] = False
    if shared is not None:
        missed[shared.member[shared.member >= 0]] = False
    missed &= prediction.unmeasured < LAST_FRAME * prediction.step.period
    if not np.count_nonzero(missed):
        return associated
    rest = blobs.take(free)
    chosen = _find_noisy(prediction, rest, missed, config)
    chosen = chosen or _find_sudden(prediction, rest, missed, config)
    if not chosen:
        return associated
    found, probability = chosen
    found = replace(found, blob=free[found.blob])
    left = associated.free.copy()
    left[found.blob[probability > 0.5]] = False
    found.extend(pairs)
    order = np.argsort(found.track, kind='stable')
    probability = np.append(probability, associated.probability)
    hard = bool(np.count_nonzero(probability == 1) == len(probability))
    return Association(found.take(order), probability[order], left, hard)


def _find_noisy(
    prediction: Prediction, blobs: Measurements, missed: Bools, config: TrackerConfig
) -> Chosen | None:
    """Find badly measured tracks: blobs of the right size within a wider gate; see _choose()."""
    wide = replace(blobs, R=STRAY_SPREAD * blobs.R)
    track, blob = gate(prediction, wide, config)
    mine = missed[track]
    if prediction.sized:
        off = prediction.sizes.difference(prediction.size[track], wide.size[blob])
        mine &= ~off.any(axis=1)
    records, aside = prediction.records, wide.z[blob] - prediction.center[track]
    before = _strays_before(prediction)
    mine &= before[track] * _is_turn(records['aside'][track], aside) < MOST_STRAYS
    chosen = _choose(prediction, wide, track[mine], blob[mine], math.log(STRAYING), missed, config)
    if chosen:
        found, _ = chosen
        track, aside = found.track, found.z - prediction.center[found.track]
        again = _is_turn(records['aside'][track], aside)
        records['strays'][track] = 1 + before[track] * again
        records['stray_at'][track], records['aside'][track] = prediction.step.now, aside
    return chosen


def _find_sudden(
    prediction: Prediction, blobs: Measurements, missed: Bools, config: TrackerConfig
) -> Chosen | None:
    """Find tracks that have suddenly moved fast or leapt, and replace their predictions.

    An object that fast is smeared, so its blob need not have its size; see _choose().
    """
    strays, T = _strays_before(prediction), prediction.unmeasured
    turned = strays >= MOST_STRAYS
    chance = SUDDEN * maneuver_chance(np.array(FIRST_RATE), T)
    chance, T = np.where(turned, TURN_CHANCE, chance), np.where(turned, (strays + 1) * T, T)
    speed = np.maximum(prediction.speed, prediction.sudden_speed)
    sudden = replace(prediction, maneuvered=chance, speed=speed, unmeasured=T)
    leap = LEAP * prediction.size * (not prediction.finds_whole)  # a network draws all of it
    pushed = np.broadcast_to(sudden.turn, leap.shape)
    sudden.turn = np.maximum(pushed, math.sqrt(3) * leap / T[:, None])
    sudden.is_scaled = True
    track, blob = gate(sudden, blobs, config)
    mine = missed[track]
    chosen = _choose(sudden, blobs, track[mine], blob[mine], 0.0, missed, config)
    if chosen:
        found, _ = chosen
        of = found.track
        aside = found.z - prediction.center[of]
        _disturb(prediction.bank, found, aside, T[of], pushed[of], leap[of] ** 2)
    return chosen


def _disturb(
    bank: Bank, found: Hypotheses, aside: Floats, T: Floats, speed: Floats, leap: Floats
) -> None:
    """Replace the predictions of tracks by mixtures of what they may have done all at once.

    What was pushed keeps its new velocity; what has leapt, its old one.

    :param aside: (K, 2) of the measurements from where tracks go on [px].
    :param T: (K,) time in which a push may have been [s].
    :param speed: (K, 2) standard deviation of the velocity after a push [px/s].
    :param leap: (K, 2) variance of a leap [px^2].
    """
    S = np.zeros((2, len(T), 2, 2))
    S[..., (0, 1), (0, 1)] = np.maximum([leap, (speed * T[:, None]) ** 2 / 3], LEAST_LEAP)
    leap_log, push_log = log_density(aside, S)
    log_odds = leap_log - push_log
    leapt = found.innovations.maneuvered / (1 + np.exp(-log_odds.clip(-50, 50)))
    bank.maneuver(found.track, found.innovations.maneuvered - leapt, T, speed)
    bank.spread(found.track, leapt[:, None] * leap)


def _strays_before(prediction: Prediction) -> Indices:
    """How many strays each track, (N,), was last measured by, on end and as it would turn."""
    records = prediction.records
    return np.asarray(records['strays'] * (records['stray_at'] == records['updated']), int)


def _is_turn(last: Floats, aside: Floats) -> Bools:
    """Which strays, (K, 2) from where tracks go on, follow the last ones, (K, 2), as turns would.

    What has turned is further aside from frame to frame, on the same side.
    """
    return np.asarray(((aside - last) * last).sum(axis=1) > 0)


def _choose(
    prediction: Prediction,
    blobs: Measurements,
    track: Indices,
    blob: Indices,
    log_prior: float,
    missed: Bools,
    config: TrackerConfig,
) -> Chosen | None:
    """Associate tracks, (K,), with blobs, (K,); None if nothing is found, as nearly always.

    :param log_prior: log of the prior probability of a stray or of a sudden start.
    :param missed: (N,) tracks without a measurement.
    """
    if not len(track):
        return None
    found = hypothesize(prediction, blobs, track, blob)
    found.innovations.log_likelihood[:] += log_prior
    gain = score(found, prediction, blobs, config)
    chosen, probability = ASSOCIATORS[config.associator](found.track, found.blob, gain)
    found = found.take(chosen)
    alone = _is_alone(prediction, found, missed).nonzero()[0]
    return (found.take(alone), probability[alone]) if len(alone) else None


def _is_alone(prediction: Prediction, found: Hypotheses, missed: Bools) -> Bools:
    """Return whether no other missed track is within twice the distance of what is found, (K,).

    A blob between two tracks belongs to both (see unresolved), or to either.
    """
    known = prediction.center[missed]
    aside = found.z - prediction.center[found.track]
    away = found.z[:, None] - known
    reach = 4 * (aside * aside).sum(axis=1)
    near = (away * away).sum(axis=2) < reach[:, None]
    return np.asarray(np.count_nonzero(near, axis=1) <= 1)
