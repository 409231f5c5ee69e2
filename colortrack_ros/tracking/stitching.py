"""Stitching: a lost track goes on as one that has just been confirmed."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.gaussian import LOG_2PI
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.estimation.gaussian import turned
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.association.gnn import associate
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.maneuvers import maneuver_chance
from colortrack_ros.tracking.prediction import assumed_speed

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

KEPT = ('track_id', 'born', 'origin', 'color', 'extent', 'partial', 'hits')
"""What a track keeps when another goes on in its place."""

REACH_SIGMAS = 7.0
"""Pairs farther apart than this many standard deviations are not compared, to save time: beyond 7
the probability is 1e-11."""

LOAD = 1e-9
"""Share by which variances are raised before a covariance is inverted. A track torn between
detections 1e6 px apart is 1e12 times less certain along one way than across, and rounding leaves it
singular. Chosen: far above rounding, 1e-16, far below what any variance is known to."""


def stitch(tracks: TrackTable[Bank], lost: Indices, found: Indices) -> None:
    """Let lost tracks, (K,), go on as found ones, (K,); their IDs and sizes stay."""
    tracks.filters.put(lost, tracks.filters.take(found))
    records = tracks.records
    hits = records['hits'][found]
    for name in records.dtype.names or ():
        if name not in KEPT:
            records[name][lost] = records[name][found]
    records['hits'][lost] += hits


def find_stitches(
    tracks: TrackTable[Bank],
    lost: Indices,
    found: Indices,
    stamp: int,
    period: float,
    learned: Adaptation,
    config: TrackerConfig,
) -> tuple[Indices, Indices]:
    """Choose pairs by the likelihood of states against that of new objects.

    What a single detection could not decide, the first few do: they are no clutter, and have a
    velocity.

    :param tracks: all.
    :param lost: coasting ones.
    :param found: others, just confirmed.
    :param stamp: now [ns].
    :param period: of the frames [s].
    :return: (K,) of the lost, and (K,) of the found that go on from them.
    """
    records = tracks.records
    one, other = (part.ravel() for part in np.meshgrid(lost, found, indexing='ij'))
    fit = records['born'][other] > records['updated'][one]
    fit &= records['color'][one] == records['color'][other]
    one, other = one[fit], other[fit]
    T = tracks.unmeasured(stamp)[one]
    speed = assumed_speed(learned, config)
    mean, cov = tracks.filters.estimate()
    reach = np.hypot(mean[one, 2], mean[one, 3]) * T
    reach += REACH_SIGMAS * np.sqrt((cov[one, 0, 0] + cov[one, 1, 1]) / 2 + (speed.max() * T) ** 2)
    apart = mean[one, :2] - mean[other, :2]
    near = np.hypot(apart[:, 0], apart[:, 1]) <= reach
    one, other, T = one[near], other[near], T[near]
    chance = maneuver_chance(records['rate'][one], T) * config.maneuvers
    gain = log_likelihood_ratio(mean, cov, one, other, chance, T, speed)
    gain += np.log(np.maximum(records['hidden'][one], 1e-9))
    gain -= np.log(learned.birth_density(records['origin'][other]))
    chosen, _ = associate(one, other, gain)
    return one[chosen], other[chosen]


def log_likelihood_ratio(
    mean: Floats,
    cov: Floats,
    lost: Indices,
    found: Indices,
    chance: Floats,
    T: Floats,
    speed: Floats,
) -> Floats:
    """How likely tracks, with their velocities, are what has become of others.

    :param mean, cov: (N, n) and (N, n, n) estimates of all tracks.
    :param lost: (K,) tracks unmeasured for a time.
    :param found: (K,) others that have begun since.
    :param chance: (K,) probability that the lost one has maneuvered.
    :param T: (K,) time that there was for it [s].
    :param speed: (2,) standard deviation of a new velocity on each axis [px/s].
    :return: (K,) log of the likelihood over that of any velocity, N(0, speed^2) [1/px^2].
    """
    one, P = mean[lost, :4], cov[lost, :4, :4]
    other, other_P = mean[found, :4], cov[found, :4, :4]
    log = [np.log1p(-chance), np.log(np.maximum(chance, TINY))]
    for i, (center, spread) in enumerate([(one, P), turned(one, P, T, speed)]):
        log[i] = log[i] + _log_density(other - center, spread + other_P)
    any_S = speed**2 * np.eye(2) + other_P[:, 2:, 2:]
    return np.asarray(np.logaddexp(*log) - _log_density(other[:, 2:], any_S))


def _log_density(e: Floats, S: Floats) -> Floats:
    """Log of N(e; 0, S), (K,), for (K, n) and (K, n, n)."""
    S = S * (1 + LOAD * np.eye(e.shape[1]))
    d2 = (e * np.linalg.solve(S, e[..., None])[..., 0]).sum(axis=1)
    return np.asarray(-0.5 * (d2 + np.linalg.slogdet(S)[1] + e.shape[1] * LOG_2PI))
