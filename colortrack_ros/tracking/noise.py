"""How noisy the detections are: a factor on the covariance that they bring, learned from them.

Four measurements in a row say how noisy they are, whatever filter is run on them: their third
difference holds nothing of a position, a velocity or an acceleration that stays. (Autocovariance
least squares, Odelson, Rajamani and Rawlings 2006, takes the innovations of a filter; those of a
filter that explains noise by maneuvers would say that there is none.)
"""

import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.tracking.recent import EVERY
from colortrack_ros.tracking.recent import GIVEN
from colortrack_ros.tracking.recent import Recent
from colortrack_ros.tracking.recent import RING
from colortrack_ros.tracking.recent import Z

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

WHITE, WANDERING = 0.881, 0.134
"""Mean cosine between third differences two frames apart, less that one frame apart, of measurement
noise alone (correlations -3/4 and 3/10) and of white acceleration alone (-1/3 and -1/6): pi/4 rho
2F1(1/2, 1/2; 2; rho^2) for normal vectors in the plane."""

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

OWN_RANGE = 4.0
"""A track's own factor stays within this of its color's, and 1 / this. Assumed."""

LEAST_SQUARE = 1e-4
"""Of a normalized difference: of what stands still to the bit."""

NOISE_FIELDS = [('evidence', 'f8', 4), ('own_factor', 'f8')]
"""What is recorded of a track: its evidence, see MeasurementNoise; and its own factor over that of
its color, less 1."""


class MeasurementNoise:
    """Learns a factor on the covariance of the detections, by color and by track.

    Evidence is four sums: how many differences there were, of the logarithms of their squares, of
    the differences of their cosines, and of the logarithms of the variances given.
    """

    def __init__(self) -> None:
        self._colors = np.zeros(0, np.uint32)
        self._evidence = np.zeros((0, 4))
        self._factors, self._usual = np.zeros(0), np.zeros(0)
        self._shrinks = False

    def factors(self, colors: NDArray[np.uint32], variance: Floats) -> Floats:
        """The factors of detections, (M,).

        A variance larger than usual says what is unusual about a detection, and that no factor
        takes away.

        :param colors: (M,), those never met have a factor of 1.
        :param variance: (M,) given [px^2].
        """
        if not len(self._colors):
            return np.ones(len(colors))
        row = np.minimum(self._colors.searchsorted(colors), len(self._colors) - 1)
        factor = np.where(self._colors[row] == colors, self._factors[row], 1.0)
        if not self._shrinks:
            return factor
        usual = np.minimum(self._usual[row] / np.maximum(variance, 1e-12), 1.0)
        return np.where(factor < 1, 1 - (1 - factor) * usual, factor)

    def learn(self, records: NDArray[np.void], track: Indices, recent: Recent) -> Floats:
        """Take the differences of the last frames.

        :param records: (N,) of all tracks, with NOISE_FIELDS and those of Recent.
        :param track: (K,) which were measured in the last frame.
        :param recent: where the frames are in the records.
        :return: (K,) by how much the factors of their colors have grown, 1 for those that have not.
        """
        newest_first = recent.newest_first()
        stamps = recent.stamps[newest_first]
        W = _third_differences(stamps)
        measured = records['measured'][track].take(newest_first, axis=1)
        variance = measured[..., GIVEN]
        difference = W @ measured[..., Z]
        scale = np.maximum(variance @ np.square(W).T, 1e-12)
        squares = difference * difference
        length2 = np.maximum((squares[..., 0] + squares[..., 1]) / scale, LEAST_SQUARE)
        direction = difference / np.sqrt(length2 * scale)[..., None]
        one = direction[:, :EVERY] * direction[:, 1:-1]
        two = direction[:, :EVERY] * direction[:, 2:]
        rise = two[..., 0] + two[..., 1] - (one[..., 0] + one[..., 1])
        whole = records['in_a_row'][track][:, None] >= np.arange(6, 6 + EVERY)
        given = np.log(np.maximum(variance[:, :EVERY], 1e-12))
        new = np.array([np.ones_like(rise), np.log(length2[:, :EVERY] / 2), rise, given])
        new = (new * whole).sum(axis=2).T
        colors, latest = records['color'][track], variance[:, 0]
        before = self.factors(colors, latest)
        self._sum(records, track, new, math.exp((stamps[EVERY] - stamps[0]) / NOISE_MEMORY))
        return np.maximum(self.factors(colors, latest) / before, 1.0)

    def _sum(
        self, records: NDArray[np.void], track: Indices, new: Floats, remembered: float
    ) -> None:
        """Add evidence to that of tracks and their colors, and draw factors from it."""
        colors = records['color'][track]
        row = self._rows(colors)
        self._evidence *= remembered
        np.add.at(self._evidence, row, new)
        count = self._evidence[:, 0]
        mean = self._evidence[:, 1:] / np.maximum(count, 1e-9)[:, None]
        mean[:, 0] -= MEAN_LOG * (count > 0)
        self._usual = np.exp(mean[:, 2].copy())
        prior = count / (count + PRIOR)
        least = np.minimum(LEAST_VARIANCE / self._usual, 1.0)
        self._factors = np.maximum(_factor(prior * mean[:, 0], mean[:, 1]), least)
        self._shrinks = bool(self._factors.min() < 1)
        evidence = remembered * records['evidence'][track] + new
        records['evidence'][track] = evidence
        share = evidence[:, 0] / (evidence[:, 0] + CROWD)
        own_mean = (evidence[:, 1] / np.maximum(evidence[:, 0], 1.0)) - MEAN_LOG
        own = np.exp(
            (share * (own_mean - mean[row, 0])).clip(-math.log(OWN_RANGE), math.log(OWN_RANGE))
        )
        records['own_factor'][track] = own - 1

    def _rows(self, colors: NDArray[np.uint32]) -> Indices:
        """Where the colors, (K,), stand in the evidence; new ones are added."""
        known = self._colors
        row = known.searchsorted(colors)
        if len(known) and np.count_nonzero(known[np.minimum(row, len(known) - 1)] != colors) == 0:
            return row
        self._colors = np.union1d(known, colors)
        evidence = np.zeros((len(self._colors), 4))
        evidence[self._colors.searchsorted(known)] = self._evidence
        self._evidence = evidence
        return self._colors.searchsorted(colors)


def _third_differences(t: Floats) -> Floats:
    """Weights of RING measurements in their third divided differences, (EVERY + 2, RING).

    :param t: (RING,) their stamps, the newest first [s].
    """
    four = np.arange(EVERY + 2)[:, None] + np.arange(4)
    apart = (t[four][:, :, None] - t[four][:, None, :]) / max(t[0] - t[1], 1e-6)
    apart[:, range(4), range(4)] = 1.0
    W = np.zeros((EVERY + 2, RING))
    with np.errstate(divide='ignore'):
        np.put_along_axis(W, four, 1 / apart.prod(axis=2), axis=1)
    return W


def _factor(log_level: Floats, cosine: Floats) -> Floats:
    """Factors, by the mean log of the squares, as of noise alone, and the mean cosine, (C,)."""
    share = (cosine - WANDERING) / (WHITE - WANDERING)
    log_noise = log_level + np.log(share.clip(0.1, 1.0))
    belief = ((share - DOUBTED) / (BELIEVED - DOUBTED)).clip(0, 1)
    log_factor = belief * log_noise + (1 - belief) * np.minimum(log_level, 0.0)
    return np.asarray(np.exp(log_factor).clip(*FACTOR_RANGE))
