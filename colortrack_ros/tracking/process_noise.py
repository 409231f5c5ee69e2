"""Process noise of each object, learned by probe filters that run beside its own.

A bank of alpha-beta filters with fixed gains follows each track (Bar-Shalom, Li and Kirubarajan
2001, 6.5). Each filter is optimal for one ratio of process to measurement noise, and the one with
the smallest innovations indicates the ratio: maximum likelihood with the level of the noise left
free (multiple model adaptive estimation, Magill 1965). The track's own filter takes no part, so its
errors cannot keep it from learning better.
"""

import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.motion.constant_velocity import REFERENCE_PERIOD
from colortrack_ros.estimation.records import Records
from colortrack_ros.tracking.noise import MEAN_LOG
from colortrack_ros.tracking.recent import EVERY
from colortrack_ros.tracking.recent import MANEUVERED
from colortrack_ros.tracking.recent import Recent
from colortrack_ros.tracking.recent import STEADY_CAMERA
from colortrack_ros.tracking.recent import UNMEASURED
from colortrack_ros.tracking.recent import VARIANCE
from colortrack_ros.tracking.recent import Z

INDICES = 10.0 ** np.arange(-5, 4.1, 0.5)
"""Tracking indices q dt^3 / r of the probes for a dt of REFERENCE_PERIOD, half a decade apart: from
objects that move straight for seconds to motion that no filter can smooth."""

LOG_STEP = math.log(10) / 6
"""Log of the time that is worth a step of the indices, in which it is cubed."""

EFFICIENCY = 6 / math.pi**2
"""Efficiency of the mean log of a squared normal pair, relative to its mean, as an estimate of its
variance: ln X has the variance pi^2 / 6 if X, exponential with mean 1, has 1."""

STEP_MEMORY = 5.0
"""Time after which an innovation has decayed to 1/e [s]. Assumed."""

CROWD_WORTH = 30.0
"""Weight, in innovations, of all other tracks together in the estimate for one. Assumed: a second
of its own counts as much."""

FORMED_AGE = 5
"""Measurements after which the innovations of a probe count. Assumed: the first few contain the
errors of its initiation."""

FIRST_NOISE, SPREAD = 1000.0, math.log(10)
"""Initial process noise [px/s^2], and the standard deviation of its log. Assumed."""

LOG_RANGE = math.log(30.0), math.log(1e5)
"""Range of the log process noise. However straight it has moved, any object may deviate by a pixel
per second from one frame to the next. Assumed."""

TURNED, SETTLED_AGE = 0.5, 15
"""Probability of a maneuver above which the probes restart, and the number of measurements after a
restart in which they do not: a filter that mistakes a steady acceleration for one maneuver after
another is not believed. Assumed: an even chance, and half a second."""

LEVEL_COUNT = 20.0
"""Weight, in innovations, of what is known of R. Assumed: R itself is learned."""

TRACKS_AT_ONCE = 200
"""Tracks processed at once, to keep intermediate results in the cache. Measured: for 1000 tracks,
50, 100, 200, 400 and all at once take 0.96, 0.75, 0.66, 0.64 and 0.79 ms a frame; for 300 tracks
0.32, 0.29, 0.26, 0.26 and 0.25."""

LEAST_NOISE = 1e-4
"""Least squared innovation over the variance of the measurement, for objects that are exactly at
rest: a hundredth of a standard deviation, so that its log does not outweigh other evidence."""


def _gains() -> tuple[Floats, Floats]:
    """Return alpha and beta, (AGES, G), by number of measurements.

    They are those of a growing memory, 2 (2k - 1) / (k (k + 1)) and 6 / (k (k + 1)), until the
    steady state of the Riccati equation is reached. For Q of white-noise acceleration it has a
    closed form, like that of Kalata 1984 for an acceleration constant over each period. With the
    tracking index L = beta^2 / (1 - alpha) and x = sqrt(1 - alpha), its three equations reduce to a
    palindromic one of fourth degree,

        y^2 - sqrt(L) y + L / 6 - 4 = 0    y = x + 1 / x
    """
    root = np.sqrt(INDICES)
    y = (root + np.sqrt(INDICES / 3 + 16)) / 2
    x = (y - np.sqrt(y * y - 4)) / 2
    k = np.arange(2, 2 + 6 / root[0])[:, None]
    alpha = np.maximum(2 * (2 * k - 1) / (k * (k + 1)), 1 - x * x)
    beta = np.maximum(6 / (k * (k + 1)), root * x)
    start = np.ones((2, len(INDICES)))
    return np.concatenate([start, alpha]), np.concatenate([0 * start, beta])


ALPHA, BETA = _gains()
LOG_EXCESS = -np.log(1 - ALPHA[-1])
"""Log of the innovation covariance over R, (G,): alpha = P / (P + R)."""

PROBES = np.arange(len(INDICES))
"""Places in INDICES, (G,)."""

STEP_FIELDS = [
    ('probe', 'f8', (2, 2, len(INDICES))),
    ('probe_age', 'i8'),
    ('fit', 'f8', len(INDICES)),
    ('fit_count', 'f8', 4),
    ('log_noise', 'f8'),
]
"""Process-noise fields of a track: positions [px] and velocities [px/s] of its probes, by axis;
number of measurements that they have processed; sums of the logs of their squared innovations; the
number of these, and the sums of the log variances of the measurements, of the log times before
them, and of the steps of INDICES that these are worth; log of its process noise relative to that of
the crowd."""


class ProcessNoise:
    """Learns the process noise of tracks, and of the crowd, which is all of them.

    :ivar log_noise: log of the sigma_s of the crowd [px/s^2].
    """

    def __init__(self) -> None:
        self._fit, self._count = np.zeros(len(INDICES)), np.zeros(4)
        self.log_noise = self._first = math.log(FIRST_NOISE)
        self._least = LOG_RANGE[0]

    def assume(self, slowness: float, share: float) -> None:
        """Assume less noise for frames farther apart than at usual rates, and for slow scenes.

        :param slowness: times that they are as far apart: what the noise adds to the variance of a
            position in a frame, q dt^3 / 3, stays as it is.
        :param share: speed over that of usual scenes: what is smaller in the picture turns less.
        """
        slower = -1.5 * math.log(slowness)
        first = math.log(FIRST_NOISE * share) + slower
        self.log_noise += first - self._first
        self._first, self._least = first, LOG_RANGE[0] + slower

    def learn(self, records: Records, track: Indices, recent: Recent) -> None:
        """Learn from the measurements of the last EVERY frames.

        :param records: (N,) of all tracks, with STEP_FIELDS and those of Recent.
        :param track: (K,) tracks measured in the last frame.
        :param recent: slots of the frames in the records.
        """
        oldest_first = recent.newest_first()[EVERY::-1]
        stamps = recent.stamps[oldest_first]
        remembered = np.exp((stamps[:-1] - stamps[1:]) / STEP_MEMORY)
        self._fit, self._count = self._fit * remembered.prod(), self._count * remembered.prod()
        for first in range(0, len(records), TRACKS_AT_ONCE):
            some = records.part(slice(first, first + TRACKS_AT_ONCE))
            self._take(some, oldest_first[1:], remembered)
        self._conclude(records, track)

    def _take(self, records: Records, slots: Indices, remembered: Floats) -> None:
        """Process the measurements of some frames for some of the tracks.

        :param slots: (F,) of the frames in Recent, the oldest first.
        :param remembered: (F,) share of earlier evidence that each frame keeps.
        """
        some = records['measured'][:, slots].swapaxes(0, 1)
        measured = some[..., UNMEASURED] > 0
        age = _ages(records['probe_age'], measured, some[..., MANEUVERED] > TURNED)
        T = np.where(measured, np.maximum(some[..., UNMEASURED], 1e-6), REFERENCE_PERIOD)
        log_time = np.log(T)
        steps = np.rint((log_time - math.log(REFERENCE_PERIOD)) / LOG_STEP)
        squares = _follow(records, some, measured, age, T, steps.astype(np.int64))
        known = measured & (some[..., STEADY_CAMERA] > 0) & (age > FORMED_AGE)
        variance = some[..., VARIANCE]
        squares += LEAST_NOISE * variance[..., None]
        fit = np.log(np.where(known[..., None], squares, 1.0))
        log_variance = np.log(np.maximum(variance, 1e-12))
        count = np.stack([np.ones_like(T), log_variance, log_time, steps], axis=-1)
        count *= known[..., None]
        for name, new in (('fit', fit), ('fit_count', count)):
            total = records[name].copy()
            for i, left in enumerate(np.where(measured, remembered[:, None], 1.0)[..., None]):
                total *= left
                total += new[i]
            records[name] = total
        since = np.append(remembered[::-1].cumprod()[-2::-1], 1.0)
        self._fit += since @ fit.sum(axis=1)
        self._count += since @ count.sum(axis=1)

    def _conclude(self, records: Records, track: Indices) -> None:
        """Compute the posterior means of ln sigma_s of the crowd and of tracks."""
        count = self._count[0]
        if count < 1:
            return
        _, level, log_time, steps = self._count / count
        typical = _log_unit(level, log_time, steps)
        log_sigma = (np.log(INDICES) + typical - math.log(REFERENCE_PERIOD)) / 2
        prior = -0.5 * ((log_sigma - self._first) / SPREAD) ** 2
        crowd = prior + _log_likelihood(self._fit, count, level, steps)
        worth = min(1.0, CROWD_WORTH / count)
        fit = records['fit'][track] + worth * self._fit
        own = records['fit_count'][track] + worth * self._count
        number, (level, log_time, steps) = own[:, :1], (own[:, 1:] / own[:, :1]).T[..., None]
        likelihood = prior + _log_likelihood(fit, number, level, steps)
        bounds = self._least, LOG_RANGE[1]
        self.log_noise = float(_mean(crowd, log_sigma).clip(*bounds))
        differs = (_log_unit(level, log_time, steps)[:, 0] - typical) / 2
        log_noise = (_mean(likelihood, log_sigma) + differs).clip(*bounds)
        records['log_noise'][track] = log_noise - self.log_noise


def _log_unit(level: Floats, log_time: Floats, steps: Floats) -> Floats:
    """Return the log of the q [px^2/s^3] that an index of 1 in INDICES stands for.

    :param level, log_time, steps: means over measurements, see STEP_FIELDS.
    """
    return level - 3 * (log_time - LOG_STEP * steps)


def _follow(
    records: Records,
    some: Floats,
    measured: Bools,
    age: NDArray[np.int64],
    T: Floats,
    steps: NDArray[np.int64],
) -> Floats:
    """Update the probes of all tracks with the measurements of some frames.

    With q T^3 / r for an index, each probe stands for the same q, however often objects are missed
    and however irregular frames are.

    :param some: (F, N, RING_COLUMNS) measurements in Recent.
    :param measured: (F, N) which tracks are measured.
    :param age: (F, N) of the probes, with these measurements.
    :param T: (F, N) times since the previous ones [s].
    :param steps: (F, N) how many indices larger than INDICES those for these times are.
    :return: (F, N, G) squared innovations [px^2].
    """
    level = np.minimum(age, len(ALPHA) - 1)[..., None]
    index = (PROBES + steps[..., None]).clip(0, len(PROBES) - 1)
    gain = np.empty((*age.shape, 2, 1, len(INDICES)))
    gain[:, :, 0, 0] = ALPHA[level, index] * measured[..., None]
    gain[:, :, 1, 0] = BETA[level, index] * (measured / T)[..., None]
    T = T * measured
    probe, e = records['probe'].copy(), np.empty((*age.shape, 2, len(INDICES)))
    for i in range(len(age)):
        probe[:, 0] += probe[:, 1] * T[i][:, None, None]
        np.subtract(some[i][:, Z, None], probe[:, 0], out=e[i])
        probe += gain[i] * e[i][:, None]
    records['probe'], records['probe_age'] = probe, age[-1]
    e *= e
    return np.asarray(e[:, :, 0] + e[:, :, 1])


def _ages(age: NDArray[np.int64], measured: Bools, turned: Bools) -> NDArray[np.int64]:
    """Return the ages of probes, (F, N), at each of some frames.

    :param age: (N,) before.
    :param measured: (F, N); turned: (F, N) where the probes restart if settled.
    """
    turned = turned & measured
    if not np.count_nonzero(turned):
        return np.asarray(age + measured.cumsum(axis=0))
    ages = np.empty(measured.shape, np.int64)
    for i in range(len(ages)):
        age = np.where(turned[i] & (age > SETTLED_AGE), 0, age) + measured[i]
        ages[i] = age
    return ages


def _log_likelihood(
    fit: Floats, count: Floats | float, log_variance: Floats | float, steps: Floats | float
) -> Floats:
    """Return log-likelihoods of the indices, by innovations and by their expected size given R."""
    mean = fit / np.maximum(count, 1.0)
    log_excess = np.interp(PROBES + steps, PROBES, LOG_EXCESS)
    excess = mean - (MEAN_LOG + math.log(2) + log_variance + log_excess)
    trusted = np.minimum(count, LEVEL_COUNT)
    return np.asarray(-EFFICIENCY * (fit + 0.5 * trusted * excess**2))


def _mean(log_weight: Floats, value: Floats) -> Floats:
    """Return the mean of value over the last axis, weighted by exp(log_weight)."""
    weight = np.exp(log_weight - log_weight.max(axis=-1, keepdims=True))
    return np.asarray((weight @ value) / weight.sum(axis=-1))
