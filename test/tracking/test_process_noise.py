"""The probes that learn the process noise, against the Riccati equation and one by one."""

import math

import numpy as np
import pytest

from colortrack_ros.estimation.motion.constant_velocity import REFERENCE_PERIOD
from colortrack_ros.estimation.records import Records
from colortrack_ros.tracking import process_noise
from colortrack_ros.tracking.process_noise import ALPHA
from colortrack_ros.tracking.process_noise import BETA
from colortrack_ros.tracking.process_noise import INDICES
from colortrack_ros.tracking.process_noise import ProcessNoise
from colortrack_ros.tracking.process_noise import STEP_FIELDS
from colortrack_ros.tracking.recent import EVERY
from colortrack_ros.tracking.recent import Recent
from colortrack_ros.tracking.recent import RECENT_FIELDS


@pytest.mark.slow
@pytest.mark.parametrize('probe', range(len(INDICES)))
def test_gains_are_in_the_end_those_of_a_kalman_filter_of_white_noise_acceleration(probe):
    F = np.array([[1, 1], [0, 1]])
    Q = INDICES[probe] * np.array([[1 / 3, 1 / 2], [1 / 2, 1]])
    P = 1e3 * np.eye(2)
    for _ in range(5000):
        P = F @ P @ F.T + Q
        K = P[:, 0] / (P[0, 0] + 1)
        P = P - np.outer(K, P[0])
    np.testing.assert_allclose([ALPHA[-1, probe], BETA[-1, probe]], K, rtol=1e-6)


@pytest.mark.parametrize('count', [2, 3, 5, 10])
def test_what_is_straight_is_fitted_by_least_squares_at_first(count):
    k = np.arange(count)
    x = np.random.default_rng(count).normal(size=count)
    place, speed = x[0], 0.0
    for n in range(1, count):
        place += speed
        alpha, beta = ALPHA[n + 1, 0], BETA[n + 1, 0]
        error = x[n] - place
        place, speed = place + alpha * error, speed + beta * error
    slope, offset = np.polyfit(k, x, 1)
    np.testing.assert_allclose([place, speed], [offset + slope * k[-1], slope], rtol=1e-9)


def one_by_one(seen, variances, turned, steady, dt):
    """Of each probe of a track: sums of log squared innovations; what else is summed of these.

    :param seen: (F, 2) positions [px], NaN where it was missed, which forgets nothing.
    :param dt: (F,) since the frame before [s].
    """
    fit, count = np.zeros(len(INDICES)), np.zeros((len(INDICES), 4))
    for probe in range(len(INDICES)):
        place, speed, age, last = np.zeros(2), np.zeros(2), 0, 0
        for k, z in enumerate(seen):
            if np.isnan(z[0]):
                continue
            T = dt[last : k + 1].sum()
            last = k + 1
            if turned[k] and age > process_noise.SETTLED_AGE:
                age = 0
            age += 1
            level = min(age, len(ALPHA) - 1)
            error = z - (place + T * speed)
            # the index that q T^3 / r is nearest to
            later = round(math.log10((T / REFERENCE_PERIOD) ** 3) / 0.5)
            then = min(max(probe + later, 0), len(INDICES) - 1)
            place = place + T * speed + ALPHA[level, then] * error
            speed = speed + BETA[level, then] / T * error
            fit[probe] *= np.exp(-dt[k] / process_noise.STEP_MEMORY)
            count[probe] *= np.exp(-dt[k] / process_noise.STEP_MEMORY)
            if age > process_noise.FORMED_AGE and steady[k]:
                square = error @ error + process_noise.LEAST_NOISE * variances[k]
                fit[probe] += np.log(square)
                count[probe] += 1, np.log(variances[k]), np.log(T), later
    return fit, count[0]


def test_all_probes_of_all_tracks_do_what_each_of_them_does_alone():
    random, frames = np.random.default_rng(0), 12 * EVERY
    dt = random.uniform(0.01, 0.08, frames)
    seen = random.normal(0, 5, (3, frames, 2)).cumsum(axis=1)
    seen[0, 20:23] = seen[1, 41] = np.nan
    variances, turned = random.uniform(0.2, 4, (3, frames)), random.random((3, frames)) < 0.05
    steady = random.random((3, frames)) < 0.8
    records = Records([*RECENT_FIELDS, *STEP_FIELDS], 3)
    recent, noise, missed = Recent(), ProcessNoise(), np.zeros(3)
    for k in range(frames):
        (track,) = np.nonzero(~np.isnan(seen[:, k, 0]))
        missed += dt[k]
        of = variances[track, k], missed[track], turned[track, k].astype(float)
        missed[track] = 0
        whole = np.ones(len(track), bool)
        given, z = np.column_stack([of[0], of[0]]), seen[track, k]
        if recent.take(records, track, z, given, *of, whole, steady[track, k], z, dt[k]):
            noise.learn(records, track, recent)
    fits = zip(seen, variances, turned, steady, strict=True)
    for i, (fit, count) in enumerate(one_by_one(*of, dt) for of in fits):
        np.testing.assert_allclose(records['fit'][i], fit, rtol=1e-9)
        np.testing.assert_allclose(records['fit_count'][i], count, rtol=1e-9)


INTERVALS = {
    'even': lambda random, _: 1.0,
    'jittered': lambda random, _: random.uniform(0.3, 1.7),
    'at random': lambda random, _: max(random.exponential(), 0.03),
    'in bursts': lambda random, k: 0.2 if k % 5 else 4.2,
    'now faster, now slower': lambda random, k: 1.0 + 2.0 * (k // 60 % 2),
}
"""Between frames, in mean periods."""


@pytest.mark.parametrize('interval', INTERVALS.values(), ids=INTERVALS)
@pytest.mark.parametrize('missed', [0.0, 0.3, 0.5])
@pytest.mark.parametrize(('period', 'sigma'), [(1 / 30, 60.0), (0.1, 300.0), (1 / 30, 1500.0)])
def test_process_noise_is_what_it_is_whenever_frames_come_and_whatever_is_missed(
    period, sigma, missed, interval
):
    """Nearly: the gains of a probe are those of intervals that all are as long as the last."""
    random, count = np.random.default_rng(1), 30
    records = Records([*RECENT_FIELDS, *STEP_FIELDS], count)
    recent, noise = Recent(), ProcessNoise()
    x, since = np.zeros((count, 2, 2)), np.zeros(count)
    for k in range(300):
        T = period * interval(random, k)
        Q = sigma**2 * REFERENCE_PERIOD * np.array([[T**3 / 3, T**2 / 2], [T**2 / 2, T]])
        x[..., 0] += T * x[..., 1]
        x += random.normal(size=x.shape) @ np.linalg.cholesky(Q).T
        (track,) = np.nonzero(random.random(count) >= missed)
        since += T
        one, yes, unmeasured = np.ones(len(track)), np.ones(len(track), bool), since[track]
        z, given = x[track, :, 0] + random.normal(size=(len(track), 2)), np.column_stack([one, one])
        since[track] = 0
        of = one, unmeasured, 0 * one, yes, unmeasured < 1.01 * T
        if recent.take(records, track, z, given, *of, z, T):
            noise.learn(records, track, recent)
    largest = 1.4 if interval is INTERVALS['even'] else 2.5
    assert 0.7 < math.exp(noise.log_noise) / sigma < largest
