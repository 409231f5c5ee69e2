"""How noisy the detections are: a factor on the covariance that they bring, learned from them.

Four measurements in a row say how noisy they are, whatever filter is run on them: their third
difference holds nothing of a position, a velocity or an acceleration that stays. (Autocovariance
least squares, Odelson, Rajamani and Rawlings 2006, takes the innovations of a filter; those of a
filter that explains noise by maneuvers would say that there is none.)
"""

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

EVERY = 5
"""Frames from one look at the differences to the next, which takes all of these, to save time."""

RING = EVERY + 5
"""Measurements that are kept for that: a third difference takes four, and is compared with those
one and two frames before."""

MEMORY = 10.0
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
motion hides the noise, no more is known than that it is not larger."""

FACTOR_RANGE = (0.01, 1e4)
"""Where the factor stays. Covariances are to be mended that are too large or too small by 10, and a
standard deviation of 1 px where nothing is given and 100 px is true."""

LEAST_VARIANCE = 0.1**2
"""No factor makes a variance smaller than this [px^2]: centroids err by shading and by the grid of
pixels as well, slowly, of which differences see nothing. About twice centroid_bias."""

OWN_RANGE = 4.0
"""A track's own factor stays within this of its color's, and 1 / this."""

LEAST_SQUARE = 1e-4
"""Of a normalized difference: of what stands still to the bit."""

FIELDS = [
    ('measured', 'f8', (RING, 3)),
    ('in_a_row', 'i8'),
    ('evidence', 'f8', 4),
    ('own_factor', 'f8'),
]
"""What is recorded of a track: its last measurements [px] and the variances given of them [px^2],
by frame, the oldest overwritten; how many there were in a row; its evidence, see
MeasurementNoise; and its own factor over that of its color, less 1."""


class MeasurementNoise:
    """Learns a factor on the covariance of the detections, by color and by track.

    Evidence is four sums: how many differences there were, of the logarithms of their squares, of
    the differences of their cosines, and of the logarithms of the variances given.
    """

    def __init__(self) -> None:
        self._colors = np.zeros(0, np.uint32)
        self._evidence = np.zeros((0, 4))
        self._factors, self._usual = np.zeros(0), np.zeros(0)
        self._stamps = np.arange(-RING, 0.0)
        self._frame = 0

    def factors(self, colors: NDArray[np.uint32], variance: Floats) -> Floats:
        """The factors of detections, (M,).

        A variance larger than usual says what is unusual about a detection, and that no factor
        takes away.

        :param colors: (M,), those never met have a factor of 1.
        :param variance: (M,) given [px^2].
        """
        if not len(self._colors):
            return np.ones(len(colors))
        row = np.searchsorted(self._colors, colors).clip(max=len(self._colors) - 1)
        factor = np.where(self._colors[row] == colors, self._factors[row], 1.0)
        usual = np.minimum(self._usual[row] / np.maximum(variance, 1e-12), 1.0)
        return np.where(factor < 1, 1 - (1 - factor) * usual, factor)

    def learn(
        self,
        records: NDArray[np.void],
        track: Indices,
        z: Floats,
        variance: Floats,
        steady: NDArray[np.bool_],
        dt: float,
    ) -> Floats | None:
        """Take what was measured in a frame.

        :param records: (N,) of all tracks, with FIELDS.
        :param track: (K,) which were measured.
        :param z: (K, 2) their measurements [px].
        :param variance: (K,) on each axis, as given [px^2].
        :param steady: (K,) measured in the last frame as well, and wholly.
        :param dt: since the last frame [s].
        :return: (K,) by how much the factors of their colors have grown, if they have.
        """
        slot = self._frame % RING
        self._stamps[slot] = self._stamps[slot - 1] + dt
        records['measured'][track, slot] = np.column_stack([z, variance])
        records['in_a_row'][track] = np.where(steady, records['in_a_row'][track] + 1, 1)
        self._frame += 1
        if self._frame % EVERY:
            return None
        before = self.factors(records['color'][track], variance)
        self._look(records, track)
        return np.maximum(self.factors(records['color'][track], variance) / before, 1.0)

    def _look(self, records: NDArray[np.void], track: Indices) -> None:
        """Take the differences of the last frames.

        :param track: (K,) of which there may be any.
        """
        newest_first = (self._frame - 1 - np.arange(RING)) % RING
        W = _third_differences(self._stamps[newest_first])
        measured = records['measured'][track][:, newest_first]
        difference = W @ measured[..., :2]
        scale = np.maximum(measured[..., 2] @ np.square(W).T, 1e-12)
        length2 = np.maximum((difference**2).sum(axis=2) / scale, LEAST_SQUARE)
        direction = difference / np.sqrt(length2 * scale)[..., None]
        one = (direction[:, :EVERY] * direction[:, 1:-1]).sum(axis=2)
        two = (direction[:, :EVERY] * direction[:, 2:]).sum(axis=2)
        whole = records['in_a_row'][track][:, None] >= np.arange(6, 6 + EVERY)
        given = np.log(np.maximum(measured[:, :EVERY, 2], 1e-12))
        squares = np.log(length2[:, :EVERY] / 2)
        new = np.stack([np.ones_like(one), squares, two - one, given], axis=2)
        new = (new * whole[..., None]).sum(axis=1)
        passed = self._stamps[newest_first[0]] - self._stamps[newest_first[EVERY]]
        self._sum(records, track, new, math.exp(-passed / MEMORY))

    def _sum(
        self, records: NDArray[np.void], track: Indices, new: Floats, remembered: float
    ) -> None:
        """Add evidence to that of tracks and their colors, and draw factors from it."""
        colors = records['color'][track]
        if not np.isin(colors, self._colors).all():
            known, self._colors = self._colors, np.union1d(self._colors, colors)
            evidence = np.zeros((len(self._colors), 4))
            evidence[np.searchsorted(self._colors, known)] = self._evidence
            self._evidence = evidence
        row = np.searchsorted(self._colors, colors)
        self._evidence *= remembered
        np.add.at(self._evidence, row, new)
        count = self._evidence[:, 0]
        mean = self._evidence[:, 1:] / np.maximum(count, 1e-9)[:, None]
        mean[:, 0] -= MEAN_LOG * (count > 0)
        self._usual = np.exp(mean[:, 2])
        prior = count / (count + PRIOR)
        least = np.minimum(LEAST_VARIANCE / self._usual, 1.0)
        self._factors = np.maximum(_factor(prior * mean[:, 0], mean[:, 1]), least)
        evidence = remembered * records['evidence'][track] + new
        records['evidence'][track] = evidence
        share = evidence[:, 0] / (evidence[:, 0] + CROWD)
        own_mean = (evidence[:, 1] / np.maximum(evidence[:, 0], 1.0)) - MEAN_LOG
        own = np.exp(
            (share * (own_mean - mean[row, 0])).clip(-math.log(OWN_RANGE), math.log(OWN_RANGE))
        )
        records['own_factor'][track] = own - 1


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
