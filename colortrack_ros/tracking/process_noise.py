"""How unsteady each object is: its process noise, learned beside its filter.

A row of alpha-beta filters of fixed gains follows each track (Bar-Shalom, Li and Kirubarajan 2001,
6.5). Each is the best for one ratio of process to measurement noise, and the one whose innovations
are smallest tells the ratio: maximum likelihood with the level of the noise left open (multiple
model adaptive estimation, Magill 1965). The filter of the track itself
has no part in it, so nothing that it wrongly believes keeps it from learning better.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_are

from colortrack_ros.estimation.motion.constant_velocity import REFERENCE_PERIOD
from colortrack_ros.tracking.noise import EVERY
from colortrack_ros.tracking.noise import MEAN_LOG

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

INDICES = 10.0 ** np.arange(-5, 4.1, 0.5)
"""Tracking indices q dt^3 / r of the probes, half a decade apart: from what is straight for seconds
to what no filter can smooth."""

EFFICIENCY = 6 / math.pi**2
"""What the mean logarithm of a squared normal pair is worth beside its mean as a measure of its
variance: the variance of ln X is pi^2 / 6 where that of X, exponential of mean 1, is 1."""

MEMORY = 5.0
"""Time after which an innovation counts 1/e [s]. Assumed."""

CROWD = 30.0
"""Innovations that all others together are worth for a track. Assumed: a second of its own counts
as much."""

FORMED = 5
"""Measurements after which the innovations of a probe are counted."""

FIRST_NOISE, SPREAD = 1000.0, math.log(10)
"""Process noise before any is learned [px/s^2], and the standard deviation of its logarithm.
Assumed."""

LOG_RANGE = math.log(30.0), math.log(1e5)
"""Where the logarithm of the process noise stays. Anything may stray by a pixel a second from one
frame to the next, however straight it went so far. Assumed."""

TURNED, SETTLED = 0.5, 15
"""Probability of a maneuver above which the probes begin anew, unless they have done so in as many
measurements: a filter that takes a steady pull for one maneuver after another is not believed."""

LEVEL_COUNT = 20.0
"""Innovations that what is known of R is worth. Assumed: it is itself learned."""

LEAST = 1e-4
"""Of a squared innovation over the variance of a measurement: of what stands still to the bit."""


def _gains() -> tuple[Floats, Floats]:
    """Alpha and beta, (AGES, G), after so many measurements.

    Of a growing memory, 2 (2k - 1) / (k (k + 1)) and 6 / (k (k + 1)), until the steady state of
    the Riccati equation is reached.
    """
    F, H = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[1.0, 0.0]])
    Q = np.array([[1 / 3, 1 / 2], [1 / 2, 1.0]])
    P = np.array([solve_discrete_are(F.T, H.T, index * Q, np.eye(1)) for index in INDICES])
    steady = P[:, :, 0] / (P[:, 0, 0] + 1)[:, None]
    k = np.arange(2, 2 + 6 / math.sqrt(INDICES[0]))[:, None]
    alpha = np.maximum(2 * (2 * k - 1) / (k * (k + 1)), steady[:, 0])
    beta = np.maximum(6 / (k * (k + 1)), steady[:, 1])
    start = np.ones((2, len(INDICES)))
    return np.concatenate([start, alpha]), np.concatenate([0 * start, beta])


ALPHA, BETA = _gains()
LOG_EXCESS = -np.log(1 - ALPHA[-1])
"""Log of the covariance of an innovation over R, (G,): alpha = P / (P + R)."""

FIELDS = [
    ('probe', 'f8', (2, len(INDICES), 2)),
    ('probe_age', 'i8'),
    ('fit', 'f8', len(INDICES)),
    ('fit_count', 'f8', 2),
    ('log_noise', 'f8'),
]
"""What is recorded of a track: positions [px] and velocities [px/s] of its probes, how many
measurements they have taken, sums of the logarithms of their squared innovations, how many there
were and the sum of the logarithms of the variances of the measurements; and the logarithm of its
process noise over that of the crowd."""


class ProcessNoise:
    """Learns the process noise of tracks, and of the crowd.

    :ivar log_noise: log of the sigma_s of the crowd [px/s^2].
    """

    def __init__(self) -> None:
        self._fit, self._count = np.zeros(len(INDICES)), np.zeros(2)
        self.log_noise = math.log(FIRST_NOISE)
        self._frame = 0

    def learn(
        self,
        records: NDArray[np.void],
        track: Indices,
        z: Floats,
        variance: Floats,
        unmeasured: Floats,
        maneuvered: Floats,
        steady: NDArray[np.bool_],
        period: float,
    ) -> None:
        """Take what was measured in a frame.

        :param records: (N,) of all tracks, with FIELDS.
        :param track: (K,) which were measured.
        :param z: (K, 2) their measurements [px].
        :param variance: (K,) of these on each axis [px^2].
        :param unmeasured: (K,) time since the last measurement [s].
        :param maneuvered: (K,) probability that the track has maneuvered in it.
        :param steady: (K,) measured in the last frame as well, and wholly.
        :param period: since the last frame [s].
        """
        T = np.maximum(unmeasured, 1e-6)[:, None, None]
        probe = records['probe'][track]
        age = records['probe_age'][track]
        age = np.where((maneuvered > TURNED) & (age > SETTLED), 0, age) + 1
        records['probe_age'][track] = age
        level = np.minimum(age, len(ALPHA) - 1)
        alpha, beta = ALPHA[level], BETA[level]
        x, v = probe[:, 0], probe[:, 1]
        x = x + v * T
        e = z[:, None] - x
        probe[:, 0] = x + alpha[..., None] * e
        probe[:, 1] = v + beta[..., None] / T * e
        records['probe'][track] = probe
        known = steady & (age > FORMED)
        squares = (e * e).sum(axis=2) + LEAST * variance[:, None]
        new = np.log(squares) * known[:, None]
        remembered = math.exp(-period / MEMORY)
        fit, count = records['fit'][track], records['fit_count'][track]
        counted = np.stack([known, known * np.log(np.maximum(variance, 1e-12))], axis=1)
        fit, count = remembered * fit + new, remembered * count + counted
        records['fit'][track], records['fit_count'][track] = fit, count
        self._fit = remembered * self._fit + new.sum(axis=0)
        self._count = remembered * self._count + counted.sum(axis=0)
        self._frame += 1
        if self._frame % EVERY == 0:
            self._conclude(records, track, period)

    def _conclude(self, records: NDArray[np.void], track: Indices, period: float) -> None:
        """Posterior means of ln q, of crowd and tracks."""
        count, log_sum = self._count
        if count < 1:
            return
        typical, noise = log_sum / count, -3 * math.log(period)
        log_sigma = (np.log(INDICES) + typical + noise - math.log(REFERENCE_PERIOD)) / 2
        prior = -0.5 * ((log_sigma - math.log(FIRST_NOISE)) / SPREAD) ** 2
        crowd = prior + _log_likelihood(self._fit, count, typical)
        worth = min(1.0, CROWD / count)
        fit = records['fit'][track] + worth * self._fit
        own = records['fit_count'][track] + worth * self._count
        level = own[:, 1] / own[:, 0]
        likelihood = prior + _log_likelihood(fit, own[:, :1], level[:, None])
        self.log_noise = float(_mean(crowd, log_sigma).clip(*LOG_RANGE))
        log_noise = (_mean(likelihood, log_sigma) + (level - typical) / 2).clip(*LOG_RANGE)
        records['log_noise'][track] = log_noise - self.log_noise


def _log_likelihood(fit: Floats, count: Floats | float, log_variance: Floats | float) -> Floats:
    """Of each index: by the size of its innovations, and by what it should be beside R."""
    mean = fit / np.maximum(count, 1.0)
    excess = mean - (MEAN_LOG + math.log(2) + log_variance + LOG_EXCESS)
    trusted = np.minimum(count, LEVEL_COUNT)
    return np.asarray(-EFFICIENCY * (fit + 0.5 * trusted * excess**2))


def _mean(log_weight: Floats, value: Floats) -> Floats:
    """Mean over the last axis by weights of which the logarithms are given."""
    weight = np.exp(log_weight - log_weight.max(axis=-1, keepdims=True))
    return np.asarray((weight @ value) / weight.sum(axis=-1))
