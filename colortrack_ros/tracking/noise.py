"""How noisy the detections are: factors on the covariance that they bring, learned from them.

Four measurements in a row say how noisy they are, whatever filter is run on them: their third
difference holds nothing of a position, a velocity or an acceleration that stays. (Autocovariance
least squares, Odelson, Rajamani and Rawlings 2006, takes the innovations of a filter; those of a
filter that explains noise by maneuvers would say that there is none.) Measurements that lie further
apart tell whether errors last longer than a frame, see lasting_errors.
"""

import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.estimation.records import Records
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

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

NOISE_MEMORY = 10.0
"""Time after which what was learned counts 1/e [s]. Assumed: detections change with light and
distance, in seconds."""

PRIOR = 3.0
"""Measurements that a factor of 1 is worth at first. Assumed: what is given is soon doubted."""

CROWD = 60.0
"""Measurements of its own that let a track count as much as all of its color. Assumed: two seconds
of them tell its variance within a fifth."""

MEAN_LOG = -0.5772156649
"""Mean of ln X for X of an exponential distribution of mean 1, as the squared length of a pair of
normal variables has: minus the Euler-Mascheroni constant. A mean of logarithms is hardly moved by
the few differences that a maneuver is in."""

DOUBTED, BELIEVED = 0.25, 0.75
"""Shares of measurement noise in the differences, between which what was given is given up: where
motion hides the noise, no more is known than that it is not larger. Assumed: half,
and half as much to both sides."""

FACTOR_RANGE = (0.01, 1e4)
"""Where the factor stays. Covariances are to be mended that are too large or too small by 10, and a
standard deviation of 1 px where nothing is given and 100 px is true."""

LEAST_VARIANCE = 0.1**2
"""No factor makes a variance smaller than this [px^2]: centroids err by shading and by the grid of
pixels as well, slowly, of which differences see nothing. About twice centroid_bias."""

OWN_RANGE = 1 / 4, 16.0
"""A track's own factor stays within these of its color's. With 4 at most, of things whose noise
differs by 20, the ellipse of 95 % holds less (`worlds "noise by size"`), with 64 as much as with
16; with 1/16 at least what is rounded and stands still nearly is taken for exact."""

LEAN_RANGE = math.log(10.0)
"""Bound of the log of the factors' ratio to their mean, by axis: noise of 0.5 and 5 px. Assumed."""

CHANCE = 2.0
"""Standard errors by which axes differ for nothing."""

LEVEL_VARIANCE, RATIO_VARIANCE = 3.06, 4.0
"""Of the logarithms, for each difference: of the squared length, and of half of the ratio of the
squares by axis. Found by drawing white errors, whose successive differences are alike."""

CHANGED = 4.0
"""Standard errors by which two looks in a row differ from what was learned, both in the same sense,
when it holds no longer: once in 10^8 looks at white errors."""

LEAST_STAIRS = 3
"""Such changes after which positions are taken for rounded ones. Assumed."""

ROUNDED = 3 / 12
"""Variance of an error of rounding over the square of the step: 1/12, and that for three frames or
so it stays alike. Assumed."""

NOISE_FIELDS = [('evidence', 'f8', SUMS), ('own_factor', 'f8')]
"""What is recorded of a track: its evidence; and its own factor over that of its color, less 1."""


class MeasurementNoise:
    """Learns factors on the covariance of the detections, by color, axis and track."""

    def __init__(self) -> None:
        self._colors = np.zeros(0, np.uint32)
        self._evidence = np.zeros((0, SUMS))
        self._off = np.zeros(0)
        self._factors, self._usual, self._lean = np.zeros((0, 2)), np.zeros(0), np.zeros(0)
        self._hidden = np.zeros((0, len(RHO)))
        self._shrinks = self._lasts = False

    def factors(self, colors: NDArray[np.uint32], variance: Floats) -> tuple[Floats, Floats]:
        """The factors of detections by axis, (M, 2), and the variance of usual ones, (M, 2) [px^2].

        What is usual is 0 where it is not known. A variance larger than usual says what is unusual
        about a detection, and that no factor takes away.

        :param colors: (M,), those never met have a factor of 1.
        :param variance: (M,) given, the mean of both axes [px^2].
        """
        if not len(self._colors):
            return np.ones((len(colors), 2)), np.zeros((len(colors), 2))
        row, known = self._look_up(colors)
        factor, usual = self._factors.take(row, axis=0), self._usual.take(row)
        if np.count_nonzero(known) < len(known):
            factor[~known], usual[~known] = 1.0, 0.0
        of_usual = factor * usual[:, None]
        if self._shrinks:
            unusual = np.minimum(usual / np.maximum(variance, 1e-12), 1.0)[:, None]
            factor = np.where(factor < 1, 1 - (1 - factor) * unusual, factor)
        return factor, of_usual

    def _look_up(self, colors: NDArray[np.uint32]) -> tuple[Indices, NDArray[np.bool_]]:
        """Rows of colors, (M,), and whether it is theirs."""
        row = np.minimum(self._colors.searchsorted(colors), len(self._colors) - 1)
        return row, self._colors[row] == colors

    def learn(self, records: Records, track: Indices, recent: Recent, predicted: Floats) -> Floats:
        """Take the differences of the last frames.

        :param records: (N,) of all tracks, with NOISE_FIELDS and those of Recent.
        :param track: (K,) which were measured in the last frame.
        :param predicted: (K,) variance of their predictions on each axis [px^2].
        :param recent: where the frames are in the records.
        :return: (K,) by how much the factors of their colors have grown, 1 for those that have not.
        """
        colors = records['color'][track]
        row = self._rows(colors)
        newest_first = recent.newest_first()
        stamps = recent.stamps[newest_first]
        measured = records['measured'][track[:, None], newest_first]
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
        self,
        records: Records,
        track: Indices,
        row: Indices,
        new: Floats,
        remembered: float,
    ) -> None:
        """Add evidence to that of tracks, and of the rows of their colors; draw factors from it."""
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

    def _is_over(self, added: Floats) -> NDArray[np.bool_]:
        """For which colors, (C,), what was learned is over, by the evidence of a look, (C, 10)."""
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
        """Draw the factors from the evidence of the colors."""
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
        factor = _factor(count / (count + PRIOR) * level, rise + weight @ (RISES[0] - RISES))
        factor *= self._hidden.sum(axis=1)
        by_axis = factor[:, None] * np.exp(self._lean[:, None] * [1, -1])
        stairs, risers = self._evidence[:, STAIRS], self._evidence[:, RISERS]
        rounded = np.where(stairs < LEAST_STAIRS, 0.0, ROUNDED * risers / np.maximum(stairs, 1.0))
        least = np.maximum(np.minimum(LEAST_VARIANCE / self._usual, 1.0), rounded / self._usual)
        self._factors = np.maximum(by_axis.clip(*FACTOR_RANGE), least[:, None])
        self._shrinks = bool(self._factors.min() < 1)

    def _rows(self, colors: NDArray[np.uint32]) -> Indices:
        """Where the colors, (K,), stand in the evidence; new ones are added."""
        known = self._colors
        if len(known):
            row, theirs = self._look_up(colors)
            if np.count_nonzero(theirs) == len(theirs):
                return row
        self._colors = np.union1d(known, colors)
        old = self._colors.searchsorted(known)
        evidence, off = np.zeros((len(self._colors), SUMS)), np.zeros(len(self._colors))
        evidence[old], off[old] = self._evidence, self._off
        self._evidence, self._off = evidence, off
        self._conclude()
        return self._colors.searchsorted(colors)


def _means(evidence: Floats, column: int) -> Floats:
    """(C,) of a column over the differences that it sums up, 0 where there were none."""
    return np.asarray(evidence[:, column] / np.maximum(evidence[:, DIFFERENCES], 1e-9))


def _factor(log_level: Floats, rise: Floats) -> Floats:
    """Factors, by the mean log of the squares, as of noise alone, and the mean rise, (C,)."""
    share = (rise - WANDERING) / (RISES[0] - WANDERING)
    log_noise = log_level + np.log(share.clip(0.1, 1.0))
    belief = ((share - DOUBTED) / (BELIEVED - DOUBTED)).clip(0, 1)
    log_factor = belief * log_noise + (1 - belief) * np.minimum(log_level, 0.0)
    return np.asarray(np.exp(log_factor))
