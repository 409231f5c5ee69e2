"""Turns: tracks that may have maneuvered are followed both ways until detections decide.

A residual of two or three standard deviations is noise or, with a few percent, a maneuver. A
Gaussian with the mean and covariance of both has a wide velocity, and would follow the noise of the
next frames. Kept apart, one of the two is usually out of the question a frame later (a Gaussian
sum, Alspach and Sorenson 1972, of two terms for each track, about its last maneuver).
"""

import numpy as np

from colortrack_ros.columns import Columns
from colortrack_ros.columns import join
from colortrack_ros.data import Indices
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.gaussian import mixture
from colortrack_ros.estimation.gaussian import turned
from colortrack_ros.estimation.motion import MotionModel
from colortrack_ros.estimation.track_table import marked
from colortrack_ros.estimation.track_table import rows_of
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.hypotheses import Association
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.measurements import both_axes
from colortrack_ros.tracking.prediction import known_acceleration
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.prediction import process_variance

UNLIKELY = 0.01
"""Maneuvers less probable than this do not change the filter, to save time. They do count in the
published covariance, see update._unsettle(). Chosen: with 0.05 a frame of ten objects takes a tenth
less, but the ellipse of what is cut holds 4 to 7 points less (`worlds "behind covers"`)."""

WIDER = 1.0
"""Least variance of the velocity that a doubt adds, over what it is without. Assumed: if it adds
less, both hypotheses are merged."""

ROUNDING_ERROR = 1e-6
"""States that differ by less are the same but for rounding [px, px/s]."""


class UndecidedTurns(Columns):
    """K tracks that went on or turned; their filters, in a bank, are the mixture of both.

    :param model: how the tracks move.
    :ivar track_id: (K,).
    :ivar both: their filters if they went on, and if they turned: a bank of two modes.
    """

    def __init__(self, model: MotionModel) -> None:
        self.track_id = np.zeros(0, np.uint32)
        self.both, self._has_modes = Bank(model), model.modes > 1
        self.both.mean, self.both.cov, self.both.weight = (
            np.repeat(field, 2, axis=0)
            for field in (self.both.mean, self.both.cov, self.both.weight)
        )

    def correct(
        self,
        prediction: Prediction,
        associated: Association,
        taken: Hypotheses,
        learned: Adaptation,
        config: TrackerConfig,
    ) -> None:
        """Update the filters of tracks that are measured, of the undecided ones in both cases.

        :param taken: the associated pairs that are more likely than not.
        """
        bank, turning = prediction.bank, (taken.innovations.maneuvered > UNLIKELY).nonzero()[0]
        if not associated.hard or self._has_modes:
            _merge_turns(prediction, associated, taken.take(turning))
            return
        if not (turning.size or self.track_id.size):
            bank.correct(taken.track, taken.z, taken.R)
            return
        turning = taken.track[turning]
        row = self._predict(prediction, turning, learned, config)
        if len(turning):
            self._begin(prediction, turning)
            row = np.concatenate([row, turning])
        bank.correct(taken.track, taken.z, taken.R)
        both, seen = self.both, np.arange(len(row))
        if len(taken) < len(bank):
            seen = marked(taken.track, len(bank))[row].nonzero()[0]
        pair = taken.track.searchsorted(row[seen])
        both.correct(seen, taken.z.take(pair, axis=0), taken.R.take(pair, axis=0))
        mean, cov = mixture(both.weight, both.mean, both.cov)
        bank.mean[0][row], bank.cov[0][row] = mean, cov
        within = np.where(both.weight[0] > 0.5, both.cov[0, :, 2, 2], both.cov[1, :, 2, 2])
        left = (cov[:, 2, 2] > (1 + WIDER) * within).nonzero()[0]
        if left.size < row.size:
            self.keep(left)

    def _predict(
        self, prediction: Prediction, again: Indices, learned: Adaptation, config: TrackerConfig
    ) -> Indices:
        """Predict both, and return the rows of the tracks.

        Tracks that are gone, or that something else has changed meanwhile, are dropped.

        :param again: tracks that may have turned in this frame.
        """
        records, bank, both = prediction.records, prediction.bank, self.both
        if not len(records):
            self.keep(again)  # none
        if not len(self):
            return again[:0]
        row, same = rows_of(records, self.track_id)
        acceleration = known_acceleration(records, config)
        both.predict(
            prediction.step.dt,
            process_variance(records, learned, config).take(row, axis=0),
            None if acceleration is None else acceleration[row],
        )
        center, weight = both.mean[..., :2], both.weight[..., None]
        mixed = bank.mean[0].take(row, axis=0)[:, :2]
        same &= both_axes(np.abs(np.add.reduce(weight * center) - mixed) < ROUNDING_ERROR)
        # what has made a track less certain, such as noise that is found to be more, does so here
        aside = center[..., 0] - mixed[:, 0]
        variance = np.add.reduce(both.weight * (both.cov[..., 0, 0] + aside * aside))
        both.cov *= (bank.cov[0, :, 0, 0][row] / variance)[:, None, None]
        if len(again):
            same &= ~marked(again, len(records))[row]
        if np.count_nonzero(same) < len(same):
            self.keep(same.nonzero()[0])
            row = row[same]
        return row

    def _begin(self, prediction: Prediction, track: Indices) -> None:
        """Follow predicted tracks, (K,), both ways."""
        both, chance = prediction.bank.take(track), prediction.maneuvered[track]
        T, speed = prediction.unmeasured[track], prediction.turn_speed(track)
        mean, cov = turned(both.mean, both.cov, T, speed)
        both.mean, both.cov = np.concatenate([both.mean, mean]), np.concatenate([both.cov, cov])
        both.weight = np.array([1 - chance, chance])
        self.track_id = join(self.track_id, prediction.records['track_id'][track])
        self.both.extend(both)


def _merge_turns(prediction: Prediction, associated: Association, turning: Hypotheses) -> None:
    """Update filters that have modes already, or uncertain measurements.

    The prediction of a track that may have turned becomes one Gaussian for both cases.
    """
    bank, track = prediction.bank, turning.track
    if len(track):
        chance, T = turning.innovations.maneuvered, prediction.unmeasured[track]
        bank.maneuver(track, chance, T, prediction.turn_speed(track))
    pairs, share = associated.pairs, None if associated.hard else associated.probability
    bank.correct(pairs.track, pairs.z, pairs.R, share)
