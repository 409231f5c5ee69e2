"""Strays: detections that lie too far from a track for the noise that is known, and yet are its.

Noise is not normal, and changes: a light goes out, a detector meets another background. A settled
track that nothing fits, and a detection that fits nobody, are then one object more likely than one
that went as another came (a second association among what is left, as of Zhang et al. 2022, by
the likelihood of a noise mixture, Tukey 1960).
"""

from dataclasses import replace
import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import TENTATIVE
from colortrack_ros.tracking.association import ASSOCIATORS
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.gating import gate
from colortrack_ros.tracking.hypotheses import Association
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.hypotheses import hypothesize
from colortrack_ros.tracking.hypotheses import score
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import LAST_FRAME
from colortrack_ros.tracking.prediction import Prediction

Indices = NDArray[np.intp]

STRAYING = 0.01
"""Probability that a detection strays. Assumed: as of an outage of all."""

STRAY_SPREAD = 5.0**2
"""Variance of what strays over that of what does not. Assumed: with 10 single errors of 20 standard
deviations break no track either, but turns are taken for strays."""

SETTLED_HITS = 12
"""Hits after which the noise of a track is known, see maneuvers.FORMED_RATE."""


def take_strays(
    prediction: Prediction,
    blobs: Measurements,
    associated: Association,
    shared: Indices,
    config: TrackerConfig,
) -> Association:
    """Give free blobs to settled tracks that have none, with the covariance of what strays.

    :param shared: tracks that share a blob, -1 for none.
    :return: the association with these pairs as well.
    """
    records, pairs = prediction.records, associated.pairs
    if len(pairs) >= len(records) or prediction.step.again:
        return associated
    free = associated.free.nonzero()[0]
    if not len(free):
        return associated
    missed = (records['state'] != TENTATIVE) & (records['hits'] >= SETTLED_HITS)
    missed[pairs.track] = False
    missed[shared[shared >= 0]] = False
    missed &= prediction.unmeasured < LAST_FRAME * prediction.step.period
    if not np.count_nonzero(missed):
        return associated
    found, probability = _find(prediction, blobs.take(free), missed, config)
    if not len(found):
        return associated
    found = replace(found, blob=free[found.blob])
    left = associated.free.copy()
    left[found.blob[probability > 0.5]] = False
    found.extend(pairs)
    order = np.argsort(found.track, kind='stable')
    probability = np.append(probability, associated.probability)
    hard = bool(np.count_nonzero(probability == 1) == len(probability))
    return Association(found.take(order), probability[order], left, hard)


def _find(
    prediction: Prediction, blobs: Measurements, missed: NDArray[np.bool_], config: TrackerConfig
) -> tuple[Hypotheses, NDArray[np.float64]]:
    """Which blobs may be strays of which tracks, and the probabilities of that.

    :param blobs: those that no track has taken; missed: (N,) which tracks have none.
    """
    wide = replace(blobs, R=STRAY_SPREAD * blobs.R)
    track, blob = gate(prediction, wide, config)
    mine = missed[track]
    if prediction.sized:
        off = prediction.sizes.difference(prediction.size[track], wide.size[blob])
        mine &= ~off.any(axis=1)
    found = hypothesize(prediction, wide, track[mine], blob[mine])
    found.innovations.log_likelihood[:] += math.log(STRAYING)
    gain = score(found, prediction, wide, config)
    chosen, probability = ASSOCIATORS[config.associator](found.track, found.blob, gain)
    found = found.take(chosen)
    alone = _is_alone(prediction, found).nonzero()[0]
    return found.take(alone), probability[alone]


def _is_alone(prediction: Prediction, found: Hypotheses) -> NDArray[np.bool_]:
    """Whether no other track is as near to what is found, (K,), within twice as far.

    What lies between two is of both (see unresolved), or nobody knows whose it is.
    """
    known = prediction.center[prediction.records['state'] != TENTATIVE]
    aside = found.z - prediction.center[found.track]
    away = found.z[:, None] - known
    reach = 4 * (aside * aside).sum(axis=1)
    near = (away * away).sum(axis=2) < reach[:, None]
    return np.asarray(np.count_nonzero(near, axis=1) <= 1)
