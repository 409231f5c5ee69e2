"""Hypotheses: which blob may be the measurement of which track."""

from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np

from colortrack_ros.columns import Columns
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.innovations import compare
from colortrack_ros.estimation.innovations import Innovations
from colortrack_ros.estimation.track_table import marked
from colortrack_ros.tracking.association import ASSOCIATORS
from colortrack_ros.tracking.association.gnn import associate
from colortrack_ros.tracking.centers import measure_centers
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import Prediction

LOG_COLORS_MIXED_UP = math.log(50)
"""Cost of a pair of different colors where color does not gate: one blob in 50 is assumed to have
the wrong color. Not fitted."""


UNDOUBTED = math.log(1000)
"""Log-likelihood ratio against a new object above which sizes are not compared. Assumed."""


@dataclass
class Hypotheses(Columns):
    """K pairs of a track and a blob, ascending by track.

    :param track: (K,).
    :param blob: (K,).
    :param z: (K, 2) position of the track as measured by the blob [px].
    :param R: (K, 2, 2) its covariance [px^2].
    :param innovations: (K,) z against its prediction.
    """

    track: Indices
    blob: Indices
    z: Floats
    R: Floats
    innovations: Innovations

    def __len__(self) -> int:
        return len(self.track)


class Association(NamedTuple):
    """The hypotheses that were chosen.

    :param pairs: K hypotheses.
    :param probability: (K,) that each is right; 1 for hard decisions.
    :param free: (M,) blobs without a track.
    :param hard: whether all probabilities are 1.
    """

    pairs: Hypotheses
    probability: Floats
    free: Bools
    hard: bool


def hypothesize(
    prediction: Prediction,
    blobs: Measurements,
    track: Indices,
    blob: Indices,
    shared: Bools | None = None,
) -> Hypotheses:
    """Compare blobs with tracks.

    :param track: (K,), ascending.
    :param blob: (K,).
    :param shared: (K,) pairs whose blob is shared by several tracks.
    """
    z, R = measure_centers(prediction, blobs, track, blob, shared)
    R *= (1.0 + prediction.records['own_factor'][track])[:, None, None]
    chance, T = prediction.maneuvered[track], prediction.unmeasured[track]
    compared = compare(prediction.bank, track, z, R, chance, T, prediction.turn_speed(track))
    return Hypotheses(track, blob, z, R, compared)


def score(
    hypotheses: Hypotheses, prediction: Prediction, blobs: Measurements, config: TrackerConfig
) -> Floats:
    """Log-likelihood ratio of each pair against a missed detection and an unrelated blob, (K,).

    (Blackman and Popoli 1999, 6.2.) Without gating all are made positive, so that any pair is
    better than none.
    """
    track, log_likelihood = hypotheses.track, hypotheses.innovations.log_likelihood
    ratio = log_likelihood - prediction.log_density + prediction.log_odds[track]
    if not config.color_gating:
        colors = prediction.records['color'][track], blobs.rows['color'][hypotheses.blob]
        ratio -= LOG_COLORS_MIXED_UP * (colors[0] != colors[1])
    if prediction.sized and len(track):
        _count_sizes(ratio, prediction, blobs, track, hypotheses.blob)
    if not config.gating:
        ratio -= ratio.min(initial=0.0) - 1.0
    if prediction.weak_below and len(track):
        weak = blobs.rows['score'].take(hypotheses.blob) < prediction.weak_below
        if np.count_nonzero(weak):
            ratio[_is_needless(ratio, track, hypotheses.blob, weak)] = -UNDOUBTED
    return ratio


def _is_needless(ratio: Floats, track: Indices, blob: Indices, weak: Bools) -> Bools:
    """Return which pairs are of a weak box of a network, and of a track that a sure box is for.

    A weak box beside a sure one is mostly the same object once more, or nothing (Zhang et al. 2022,
    ByteTrack), however well it fits.

    :param ratio: (K,) of pairs of a track and a blob.
    :param weak: (K,) pairs with a weak box.
    """
    sure = (~weak).nonzero()[0]
    chosen, _ = associate(track[sure], blob[sure], ratio[sure])
    return weak & marked(track[sure[chosen]], int(track.max()) + 1)[track]


def _count_sizes(
    ratio: Floats, prediction: Prediction, blobs: Measurements, track: Indices, blob: Indices
) -> None:
    """Add the log-likelihood ratio of sizes to ratios, (K,), where it may decide.

    That is where several tracks compete for a blob, or none is likely. A blob of nobody's size is
    merged, cut or broken, and may belong to any of them, unless the detector finds whole objects.
    """
    open_ = ((ratio < UNDOUBTED) | (np.bincount(blob)[blob] > 1)).nonzero()[0]
    if not len(open_):
        return
    track, blob = track[open_], blob[open_]
    fit = prediction.log_fit(track, blobs.size.take(blob, axis=0))
    ratio[open_] += fit
    if not prediction.finds_whole:
        best = np.zeros(len(blobs)) - np.inf
        np.maximum.at(best, blob, fit)
        ratio[open_] -= np.minimum(best[blob], 0.0)


def choose_hypotheses(
    hypotheses: Hypotheses, gain: Floats, count: int, associator: str
) -> Association:
    """Choose hypotheses by their gains, (K,), of a number of blobs."""
    chosen, probability = ASSOCIATORS[associator](hypotheses.track, hypotheses.blob, gain)
    pairs = hypotheses if len(chosen) == len(hypotheses) else hypotheses.take(chosen)
    hard = np.count_nonzero(probability == 1) == len(probability)
    free = ~marked(pairs.blob if hard else pairs.blob[probability > 0.5], count)
    return Association(pairs, probability, free, hard)
