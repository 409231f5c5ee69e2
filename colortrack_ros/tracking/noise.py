"""Measurement noise: factors on the covariance of the detections, learned from the detections.

The third difference of four successive measurements shows their noise, whatever filter runs on
them: a constant position, velocity or acceleration cancels in it. (Autocovariance least squares,
Odelson, Rajamani and Rawlings 2006, uses the innovations of a filter. If the filter explains noise
by maneuvers, its innovations show none.) Measurements further apart show whether errors last longer
than a frame, see lasting_errors.
"""

import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.records import Records
from colortrack_ros.tracking.box_errors import BoxErrors
from colortrack_ros.tracking.differences import DIFFERENCES
from colortrack_ros.tracking.differences import GIVEN_LOG
from colortrack_ros.tracking.differences import LEAN
from colortrack_ros.tracking.differences import LOG
from colortrack_ros.tracking.differences import LOOKS
from colortrack_ros.tracking.differences import RISE
from colortrack_ros.tracking.differences import RISERS
from colortrack_ros.tracking.differences import STAIRS
from colortrack_ros.tracking.differences import SUMS
from colortrack_ros.tracking.differences import tell
from colortrack_ros.tracking.differences import TWO_APART
from colortrack_ros.tracking.lasting_errors import COSINE_VARIANCE
from colortrack_ros.tracking.lasting_errors import passed_on
from colortrack_ros.tracking.lasting_errors import RHO
from colortrack_ros.tracking.lasting_errors import RISES
from colortrack_ros.tracking.lasting_errors import SHOWN_BY_NEIGHBORS
from colortrack_ros.tracking.lasting_errors import WANDERING
from colortrack_ros.tracking.lasting_errors import weigh
from colortrack_ros.tracking.recent import EVERY
from colortrack_ros.tracking.recent import GIVEN
from colortrack_ros.tracking.recent import Recent
from colortrack_ros.tracking.recent import VARIANCE

NOISE_MEMORY = 10.0
"""Time after which evidence has decayed to 1/e [s]. Assumed: light and distance, and with them the
noise, change within seconds."""

PRIOR = 1.0
"""Weight of the initial factor of 1 in differences: a prior standard deviation of its log of 1.7,
that is of standard deviations given that are wrong by a factor of 2.4 either way. Assumed."""

CROWD = 60.0
"""Measurements after which a track's own evidence weighs as much as that of its color. Assumed: two
seconds of them give its variance within a fifth."""

MEAN_LOG = -0.5772156649
"""Mean of ln X for an exponential X of mean 1, such as half the squared length of a pair of
standard normal variables: minus the Euler-Mascheroni constant. A mean of logs is robust against the
few differences that contain a maneuver."""

DOUBTED, BELIEVED = 0.25, 0.75
"""Shares of measurement noise in the differences between which the given variance is replaced by
the learned one. Where motion hides the noise, the differences only show that it is not larger.
Assumed: one half, plus and minus half of it."""

NOISE_SHARES = np.linspace(0.0, 1.0, 21)
"""Shares of noise that are compared. The few differences of one new object hardly tell the share,
so it is averaged over."""

UNDISTURBED = 60.0
"""Differences over their number are the prior odds that no motion shows in any; else all shares are
as likely. A rate of maneuvers with an exponential prior gives such odds. Assumed: one in 2 s at 30
frames/s, as maneuvers.FIRST_RATE."""

LEAST_NOISE_SHARE = 0.1
"""Least share that differences are corrected by. Assumed."""

FACTOR_RANGE = (0.01, 1e4)
"""Range of the factor. It has to correct covariances that are off by 10 either way, and a standard
deviation of 1 px, the default, where 100 px is true."""

LEAST_VARIANCE = 0.1**2
"""Least variance after applying a factor [px^2]: shading and the pixel grid cause further errors,
too slow to show in differences. About twice centroid_bias."""

OWN_RANGE = 1 / 4, 16.0
"""Range of a track's own factor relative to that of its color. With an upper bound of 4, and
objects whose noise differs by 20, the 95 % ellipse covers less (`worlds "noise by size"`); 64
covers as much as 16. With a lower bound of 1/16, rounded positions of an object nearly at rest pass
for exact ones."""

LEAN_RANGE = math.log(10.0)
"""Bound of the log ratio of the factors by axis to their mean: noise of 0.5 and 5 px. Assumed."""

CHANCE = 2.0
"""Standard errors by which the axes may differ by chance: 95 % of the time they differ by less."""

LEVEL_VARIANCE, RATIO_VARIANCE = 3.06, 4.0
"""Variances, per difference, of the log squared length, and of half the log ratio of the squares by
axis. Found by drawing white errors, whose successive differences are correlated."""

UNSTATED = math.exp(LEVEL_VARIANCE / PRIOR / 2)
"""First factor where no variance is stated: the mean over the median of a log-normal one that is as
unsure as PRIOR says."""

CHANGED = 4.0
"""Standard errors by which two successive looks must deviate from what was learned, in the same
direction, to discard it: once in 10^8 looks at white errors."""

LEAST_STAIRS = 3
"""Least number of single steps at which positions count as rounded. Assumed."""

ROUNDED = 3 / 12
"""Variance of rounding errors over the square of the step: 1/12, and three times that because an
error stays the same for about three frames. Assumed."""

NOISE_FIELDS = [('evidence', 'f8', SUMS), ('own_factor', 'f8')]
"""Noise fields of a track: its evidence, and its own factor over that of its color, minus 1."""


class MeasurementNoise:
    """Learns factors on the covariance of the detections, by color, axis and track."""

    def __init__(self) -> None:
        self.guessed = np.zeros(0, np.uint32)
        """Colors of the last detections that stated no covariance."""
        self.boxes = BoxErrors()
        self._colors, self._were_guessed = np.zeros(0, np.uint32), np.zeros(0, bool)
        self._evidence = np.zeros((0, SUMS))
        self._off = np.zeros(0)
        self._factors, self._usual, self._lean = np.zeros((0, 2)), np.zeros(0), np.zeros(0)
        self._hidden = np.zeros((0, len(RHO)))
        self._shrinks = self._lasts = False

    def factors(self, colors: NDArray[np.uint32], variance: Floats) -> tuple[Floats, Floats]:
        """Return the factors by axis, (M, 2), and variances of typical detections, (M, 2) [px^2].

        The typical variance is 0 while unknown. A given variance above it marks an unusual
        detection, and no factor takes that away.

        :param colors: (M,); unknown ones have a factor of 1, or UNSTATED.
        :param variance: (M,) given, the mean of both axes [px^2].
        """
        if not len(self._colors):
            return self._first(colors), np.zeros((len(colors), 2))
        row, known = self._look_up(colors)
        factor, usual = self._factors.take(row, axis=0), self._usual.take(row)
        if np.count_nonzero(known) < len(known):
            factor[~known], usual[~known] = self._first(colors[~known]), 0.0
        of_usual = factor * usual[:, None]
        if self._shrinks:
            unusual = np.minimum(usual / np.maximum(variance, 1e-12), 1.0)[:, None]
            factor = np.where(factor < 1, 1.0 - (1.0 - factor) * unusual, factor)
        return factor, of_usual

    def _first(self, colors: NDArray[np.uint32]) -> Floats:
        """Return the factors by axis, (M, 2), of colors of which nothing has been learned."""
        return np.where(np.isin(colors, self.guessed), UNSTATED, 1.0)[:, None].repeat(2, axis=1)

    def _look_up(self, colors: NDArray[np.uint32]) -> tuple[Indices, Bools]:
        """Return the rows of colors, (M,), and whether each color is known, (M,)."""
        row = np.minimum(self._colors.searchsorted(colors), len(self._colors) - 1)
        return row, self._colors[row] == colors

    def learn(self, records: Records, track: Indices, recent: Recent, predicted: Floats) -> Floats:
        """Learn from the differences of the last frames.

        :param records: (N,) of all tracks, with NOISE_FIELDS and those of Recent.
        :param track: (K,) tracks measured in the last frame.
        :param predicted: (K,) variance of their predictions on each axis [px^2].
        :param recent: slots of the frames in the records.
        :return: (K,) growth of the factors of their colors; 1 for those that have not grown.
        """
        colors = records['color'][track]
        row = self._rows(colors)
        newest_first = recent.newest_first()
        stamps = recent.stamps[newest_first]
        measured = records['measured'][track[:, None], newest_first]
        if len(self.guessed):
            self.boxes.learn(measured)
        new = tell(measured, stamps, records['in_a_row'][track], self._lean[row])
        latest = measured[:, 0, GIVEN].mean(axis=1)
        before, own = self.factors(colors, latest)[0], records['own_factor'][track]
        self._sum(records, track, row, new, math.exp((stamps[EVERY] - stamps[0]) / NOISE_MEMORY))
        if self._lasts:
            used = measured[:, 0, VARIANCE] * (1 + own)
            gain = predicted / np.maximum(predicted + used, 1e-12)
            share = self._hidden[row] / self._hidden[row].sum(axis=1, keepdims=True)
            mean = (share * passed_on(gain)).sum(axis=1)
            records['own_factor'][track] = (1 + records['own_factor'][track]) * mean - 1
        grown = self.factors(colors, latest)[0] / before
        return np.maximum(grown.max(axis=1), 1.0)

    def _sum(
        self, records: Records, track: Indices, row: Indices, new: Floats, remembered: float
    ) -> None:
        """Add evidence to that of tracks and of their colors' rows, and update the factors."""
        added = np.zeros_like(self._evidence)
        np.add.at(added, row, new)
        self._evidence *= remembered
        over = self._is_over(added)
        if np.count_nonzero(over):
            self._evidence[over] = 0.0
            of, known = self._look_up(records['color'])
            records['evidence'][known & over[of]] = 0.0
        self._evidence += added
        self._conclude()
        evidence = remembered * records['evidence'][track] + new
        records['evidence'][track] = evidence
        share = evidence[:, DIFFERENCES] / (evidence[:, DIFFERENCES] + CROWD)
        beyond = _means(evidence, LOG) - _means(self._evidence, LOG)[row]
        own = np.exp((share * beyond).clip(*np.log(OWN_RANGE)))
        records['own_factor'][track] = own - 1

    def _is_over(self, added: Floats) -> Bools:
        """Return for which colors, (C,), what was learned is obsolete.

        :param added: (C, 10) evidence of one look.
        """
        both = (
            np.maximum(self._evidence[:, DIFFERENCES], 1e-9),
            np.maximum(added[:, DIFFERENCES], 1e-9),
        )
        error = np.sqrt(LEVEL_VARIANCE * (1 / both[0] + 1 / both[1]))
        off = (_means(added, LOG) - _means(self._evidence, LOG)) / error
        over = (np.minimum(np.abs(off), np.abs(self._off)) > CHANGED) & (off * self._off > 0)
        self._off = np.where(over, 0.0, off)
        return np.asarray(over)

    def _conclude(self) -> None:
        """Compute the factors from the evidence of the colors."""
        count = self._evidence[:, DIFFERENCES]
        level = _means(self._evidence, LOG) - MEAN_LOG * (count > 0)
        rise, lean = _means(self._evidence, RISE), _means(self._evidence, LEAN)
        self._usual = np.exp(_means(self._evidence, GIVEN_LOG))
        looks = self._evidence[:, LOOKS]
        growths = self._evidence[:, TWO_APART:STAIRS] / np.maximum(looks, 1e-9)[:, None]
        weight = weigh(looks, growths, count, rise)
        self._hidden = weight / SHOWN_BY_NEIGHBORS
        self._lasts = bool(np.count_nonzero(weight[:, 1:]))
        chance = CHANCE * np.sqrt(RATIO_VARIANCE / np.maximum(count, 1.0))
        certain = np.sign(lean) * np.maximum(np.abs(lean) - chance, 0.0)
        self._lean = certain.clip(-LEAN_RANGE, LEAN_RANGE)
        # the mean of a variance whose log is normal, not its median
        level += LEVEL_VARIANCE / (count + PRIOR) / 2
        level *= count / (count + PRIOR)
        level += self._were_guessed * math.log(UNSTATED) * (PRIOR / (count + PRIOR)) ** 2
        rise = rise + weight @ (RISES[0] - RISES)
        factor = _factor(level, rise, count)
        factor *= self._hidden.sum(axis=1)
        by_axis = factor[:, None] * np.exp(self._lean[:, None] * [1, -1])
        stairs, risers = self._evidence[:, STAIRS], self._evidence[:, RISERS]
        rounded = np.where(stairs < LEAST_STAIRS, 0.0, ROUNDED * risers / np.maximum(stairs, 1.0))
        least = np.maximum(np.minimum(LEAST_VARIANCE / self._usual, 1.0), rounded / self._usual)
        self._factors = np.maximum(by_axis.clip(*FACTOR_RANGE), least[:, None])
        self._shrinks = bool(self._factors.min() < 1)

    def _rows(self, colors: NDArray[np.uint32]) -> Indices:
        """Return the rows of colors, (K,), in the evidence; add unknown ones."""
        known = self._colors
        if len(known):
            row, theirs = self._look_up(colors)
            if np.count_nonzero(theirs) == len(theirs):
                return row
        self._colors = np.union1d(known, colors)
        old = self._colors.searchsorted(known)
        evidence, off = np.zeros((len(self._colors), SUMS)), np.zeros(len(self._colors))
        guessed = np.isin(self._colors, self.guessed)
        evidence[old], off[old], guessed[old] = self._evidence, self._off, self._were_guessed
        self._evidence, self._off, self._were_guessed = evidence, off, guessed
        self._conclude()
        return self._colors.searchsorted(colors)


def _means(evidence: Floats, column: int) -> Floats:
    """Return the mean of a column per difference, (C,); 0 without differences."""
    return np.asarray(evidence[:, column] / np.maximum(evidence[:, DIFFERENCES], 1e-9))


def _factor(log_level: Floats, rise: Floats, count: Floats) -> Floats:
    """Return factors, (C,), averaged over the shares of noise that the rises allow.

    :param log_level: (C,) mean log squares, as if all were noise.
    :param rise, count: (C,) mean rises, and the number of differences that they are of.
    """
    off = rise[:, None] - WANDERING - NOISE_SHARES * (RISES[0] - WANDERING)
    weight = np.exp(-count[:, None] * off**2 / (2 * COSINE_VARIANCE))
    weight[:, -1] *= UNDISTURBED * (len(NOISE_SHARES) - 1) / np.maximum(count, 1e-9)
    log_noise = log_level[:, None] + np.log(np.maximum(NOISE_SHARES, LEAST_NOISE_SHARE))
    belief = ((NOISE_SHARES - DOUBTED) / (BELIEVED - DOUBTED)).clip(0, 1)
    log_factor = belief * log_noise + (1 - belief) * np.minimum(log_level, 0.0)[:, None]
    # Sums divided: where all factors are 1, their mean is exactly that.
    return np.asarray((weight * np.exp(log_factor)).sum(axis=1) / weight.sum(axis=1))
