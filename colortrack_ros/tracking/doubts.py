"""Doubts: what looks like a maneuver may be an outlier.

A single frame cannot tell the two apart; the next detection can. Until then the track is also kept
as predicted without the doubtful detection, and continues from there if that fits the next one
better (multiple hypotheses, pruned one scan later; Blackman 2004).
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.gaussian import log_density
from colortrack_ros.estimation.track_table import rows_of
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.hypotheses import Association
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import known_acceleration
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.prediction import process_variance
from colortrack_ros.tracking.prediction import Step
from colortrack_ros.tracking.rectangles import nearest_points
from colortrack_ros.tracking.strays import SETTLED_HITS
from colortrack_ros.tracking.strays import STRAY_SPREAD
from colortrack_ros.tracking.strays import STRAYING

LIKELY_TURNED = 0.5
"""Probability of a maneuver above which the detection is doubted. Assumed: an even chance."""

SURPRISING = 13.8
"""Squared Mahalanobis distance beyond which a detection fits no prediction: 99.9 % of the right
ones lie within (chi-square, two degrees of freedom). The better of two bad fits means nothing."""

WAITING_FRAMES = 3.5
"""Frames within which a deciding detection has to arrive; after that, neither position is known
well enough. Assumed."""


@dataclass
class DoubtedTurns(Columns):
    """K tracks that may not have turned.

    :param track_id: (K,) ascending.
    :param bank: their filters as they would be without the detection that is doubted.
    :param log_odds: (K,) of that against what was taken for true.
    """

    track_id: NDArray[np.uint32]
    bank: Bank
    log_odds: Floats


def doubt(prediction: Prediction, associated: Association) -> DoubtedTurns | None:
    """Remember tracks that are about to be updated as having turned; None for none."""
    pairs, records, bank = associated.pairs, prediction.records, prediction.bank
    turned = (pairs.innovations.maneuvered > LIKELY_TURNED).nonzero()[0]
    if not len(turned) or not associated.hard or bank.model.modes > 1 or prediction.step.again:
        return None
    turned = turned[records['hits'][pairs.track[turned]] >= SETTLED_HITS]
    track = pairs.track[turned]
    e = pairs.z[turned] - prediction.center[track]
    S = bank.cov[0, track, :2, :2] + STRAY_SPREAD * pairs.R[turned]
    log_odds = math.log(STRAYING) + log_density(e, S)
    log_odds -= pairs.innovations.log_likelihood[turned]
    return DoubtedTurns(records['track_id'][track], bank.take(track), log_odds)


def reconsider(
    tracks: TrackTable[Bank],
    doubts: DoubtedTurns | None,
    blobs: Measurements,
    learned: Adaptation,
    config: TrackerConfig,
    step: Step,
) -> DoubtedTurns | None:
    """Let tracks go on from before what they took, if that explains the next detections better.

    :param tracks: as they were after the last frame.
    :return: what is doubted still, as nothing has been detected near either place.
    """
    if not doubts or step.again or not len(tracks) or not learned.camera.stands:
        return None
    records = tracks.records
    row, there = rows_of(records, doubts.track_id)
    live = there.nonzero()[0]
    row, doubts = row[live], doubts.take(live)
    before, now = doubts.bank.take(np.arange(len(row))), tracks.filters.take(row)
    doubted = records.take(row)
    variance = process_variance(doubted, learned, config)
    for bank in (before, now):
        bank.predict(step.dt, variance, known_acceleration(doubted, config))
    floor = math.log(config.clutter_density or learned.density)
    fit = [np.maximum(_nearest(bank, blobs), floor) for bank in (before, now)]
    back = ((fit[0] > floor) & (fit[0] - fit[1] + doubts.log_odds > 0)).nonzero()[0]
    tracks.filters.put(row[back], doubts.bank.take(back))
    passed = (step.now - records['updated'][row]) / NANOSECONDS
    waits = np.maximum(fit[0], fit[1]) == floor
    waits &= passed < WAITING_FRAMES * step.period
    left = DoubtedTurns(doubts.track_id, before, doubts.log_odds).take(waits)
    return left if len(left) else None


def join(one: DoubtedTurns | None, other: DoubtedTurns | None) -> DoubtedTurns | None:
    """Both; of a track that is in both the later, other."""
    if one is None or other is None:
        return one or other
    one.keep(~np.isin(one.track_id, other.track_id))
    one.extend(other)
    return one.take(one.track_id.argsort())


def _nearest(bank: Bank, blobs: Measurements) -> Floats:
    """Log-likelihoods of the detections nearest to what is predicted, (K,); -inf if far."""
    if not len(blobs):
        return np.full(len(bank), -np.inf)
    center = bank.mean[0, :, :2]
    blob = nearest_points(blobs.z, center)
    S = bank.cov[0, :, :2, :2] + blobs.R[blob]
    fit, best = log_density(blobs.z[blob] - center, S), log_density(np.zeros(center.shape), S)
    return np.where(2 * (best - fit) > SURPRISING, -np.inf, fit)
