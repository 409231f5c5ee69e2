"""Stitching: a lost track continues as one that has just been confirmed."""

import math

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.gaussian import LOG_2PI
from colortrack_ros.estimation.gaussian import TINY
from colortrack_ros.estimation.gaussian import turned
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.association.gnn import associate
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.maneuvers import maneuver_chance
from colortrack_ros.tracking.population import Population
from colortrack_ros.tracking.prediction import assumed_speed
from colortrack_ros.tracking.sizes import both_ways
from colortrack_ros.tracking.sizes import Sizes
from colortrack_ros.tracking.sizes import total

KEPT = (
    'track_id', 'born', 'origin', 'color', 'extent', 'growth', 'partial', 'nearness', 'aloft',
    'rival', 'met', 'apart', 'before', 'before_cov', 'before_size', 'sums', 'scans',
    'size_log_ratio',
)  # fmt: skip
"""Fields of a lost track that the new one takes over."""

ADDED = ('hits', 'gaps')
"""Fields of a lost track that are added to those of the new one."""

REACH_SIGMAS = 7.0
"""Pairs more than this many standard deviations apart are not compared, to save time: beyond 7 the
probability is 1e-11."""

LOAD = 1e-9
"""Relative increase of variances before a covariance is inverted. With detections 1e6 px apart, a
track is 1e12 times less certain in one direction than across, and rounding makes its covariance
singular. Chosen far above rounding, 1e-16, and far below the accuracy of any variance."""

WAITED, ANYWHERE = 0.15, 0.02
"""Shares of the objects that reappear after a long time where they had disappeared, and anywhere.
Assumed."""

WAITING = 100.0
"""Standard deviation of the distance at which the first reappear [px]: about the width of what
hides them. Assumed."""

ALMOST = 1 - 2.0**-53
"""The largest probability below 1, so that its complement has a logarithm."""

CERTAIN, LIKELY = 1e3, math.log(1e3)
"""Gain of pairs when all objects of the color are known: larger than all other terms for remembered
tracks; for coasting ones, which may still be elsewhere, odds of a thousand that the confirmed track
is an object. Assumed."""


def stitch(tracks: TrackTable[Bank], found: Indices, lost: Records) -> None:
    """Give new tracks, (K,), the IDs and sizes of lost ones, (K,) records."""
    records = tracks.records
    edged, size = lost['edged'], both_ways(total(lost['extent']))
    records['whole'][found] = np.where(edged[..., None], lost['whole'], size)
    records['emerging'][found] = lost['emerging'] & edged
    for name in KEPT:
        records[name][found] = lost[name]
    for name in ADDED:
        records[name][found] += lost[name]


def find_stitches(
    lost: TrackTable[Bank],
    found: TrackTable[Bank],
    stamp: int,
    period: float,
    learned: Adaptation,
    config: TrackerConfig,
    population: Population,
) -> tuple[Indices, Indices]:
    """Choose pairs by the likelihood of their states against that of new objects.

    The first few detections decide what one could not: they are not clutter, and they have a
    velocity. Objects remembered for a long time may have been carried anywhere, and may reappear in
    any frame.

    :param lost: N unmeasured tracks, predicted to the stamp.
    :param found: M others, just confirmed.
    :param stamp: now [ns].
    :param period: of the frames [s].
    :return: (K,) indices of lost tracks, and (K,) of the new ones that continue them.
    """
    fit = found.records['born'] > lost.records['updated'][:, None]
    fit |= found.records['host'] == lost.records['track_id'][:, None]
    fit &= found.records['color'] == lost.records['color'][:, None]
    one, other = fit.nonzero()
    unmeasured = lost.unmeasured(stamp)
    remembered = unmeasured > config.max_time_since_update
    moved = _compare_states(lost, found, unmeasured, one, other, learned, config)
    waited = _reappearing(lost, found, one, other, learned.birth_area)
    gain = np.where(remembered[one], np.logaddexp(waited, moved), moved)
    gap = (found.records['born'][other] - lost.records['updated'][one]) / NANOSECONDS
    gain += _log_prior(lost, remembered, unmeasured, gap, one, period, learned, config)
    gain -= np.log(learned.birth_places(found.records['origin']))[other]
    gain += remembered[one] * _compare_sizes(lost, found, one, other, learned.sizes)
    gain[_is_repeated(lost, found, one, other)] = CERTAIN
    no_other = np.where(remembered, CERTAIN, LIKELY)[one]
    gain += no_other * population.is_complete(found.records['color'])[other]
    chosen, _ = associate(one, other, gain)
    return one[chosen], other[chosen]


def _is_repeated(
    lost: TrackTable[Bank], found: TrackTable[Bank], one: Indices, other: Indices
) -> Bools:
    """Which pairs, (K,), are one object: the new track started inside the lost one's box.

    If an object is detected twice just as it turns, its track may take the wrong detection, and the
    next ones go to the track that started on the right one.
    """
    before, after = lost.records.take(one), found.records.take(other)
    sized = (before['extent'].sum(axis=1) > 0).all(axis=1)
    return np.asarray(sized & (after['host'] == before['track_id']))


def _compare_states(
    lost: TrackTable[Bank],
    found: TrackTable[Bank],
    unmeasured: Floats,
    one: Indices,
    other: Indices,
    learned: Adaptation,
    config: TrackerConfig,
) -> Floats:
    """Log-likelihood ratio of pairs by their states, (K,); -inf where too far apart.

    :param unmeasured: (N,) time since the lost tracks were measured [s].
    :param one, other: (K,) indices of lost and of new tracks.
    """
    speed = assumed_speed(learned, config)
    (before, before_cov), (after, after_cov) = lost.filters.estimate(), found.filters.estimate()
    mean = np.concatenate([before[:, :4], after[:, :4]])
    cov = np.concatenate([before_cov[:, :4, :4], after_cov[:, :4, :4]])
    near = _is_near(mean, cov, one, len(lost) + other, unmeasured[one], speed)
    track, T = one[near], unmeasured[one[near]]
    chance = maneuver_chance(lost.records['rate'][track], T) * config.maneuvers
    ratio = np.full(len(one), -np.inf)
    ratio[near] = log_likelihood_ratio(mean, cov, track, len(lost) + other[near], chance, T, speed)
    return ratio


def _reappearing(
    lost: TrackTable[Bank], found: TrackTable[Bank], one: Indices, other: Indices, area: float
) -> Floats:
    """Log of the density, (K,) [1/px^2], of reappearing there without having moved on.

    The object has waited where it was hidden, or was carried anywhere. What a turn of the camera
    took out of view is where it was.
    """
    way = (found.records['origin'][other] - lost.records['seen'][one]) / WAITING
    waited = np.exp(-0.5 * (way**2).sum(axis=1)) / (2 * np.pi * WAITING**2)
    anywhere = np.where(_turned_away(lost.records), 0.0, ANYWHERE / area)
    return np.asarray(np.log(np.maximum(WAITED * waited + anywhere[one], TINY)))


def _turned_away(records: Records) -> Bools:
    """Which lost objects, (N,), a known turn of the camera has taken out of view."""
    return np.asarray(records['left'] > records['updated'])


def _log_prior(
    lost: TrackTable[Bank],
    remembered: Bools,
    unmeasured: Floats,
    gap: Floats,
    one: Indices,
    period: float,
    learned: Adaptation,
    config: TrackerConfig,
) -> Floats:
    """Log of the probability of pairs, (K,), that the lost object appears, over that of a new one.

    A known turn of the camera, which took an object out of the picture, also tells when it returns.

    :param remembered, unmeasured: (N,) of the lost tracks.
    :param gap: (K,) from the last measurement of the lost track to the first of the new one [s].
    :param one: (K,) indices of lost tracks.
    """
    records = lost.records
    share, seen = np.array(records['hidden_share']), records['seen']
    share[remembered] = learned.disappearances.share_of_deleted(
        seen[remembered], learned.area, records['leaving'][remembered]
    )
    share[records['splinter']] = 0.0
    detected = learned.detection_rate.estimate(config.detection_probability)
    back = learned.disappearances.return_odds(share[one], gap, unmeasured[one], detected, period)
    odds = back / learned.expected_births
    expected = np.maximum(records['hidden'], 1e-9) / learned.births
    odds = np.where(_turned_away(records)[one], expected[one], odds)
    return np.asarray(np.log(np.maximum(odds, TINY)))


def _compare_sizes(
    lost: TrackTable[Bank], found: TrackTable[Bank], one: Indices, other: Indices, sizes: Sizes
) -> Floats:
    """Log-likelihood ratio of sizes, (K,), where known, for all detections of the new track.

    Of an object that emerges from behind another only a part may be visible: if the new track is
    smaller than the lost ones, it may be any of them.
    """
    size, now = (table.records['extent'].sum(axis=1) for table in (lost, found))
    size, now = size[one], now[other]
    known = (size > 0).all(axis=1) & (now > 0).all(axis=1)
    fit = np.where(known, sizes.log_fit(size, now), 0.0)
    best = np.full(len(found), -np.inf)
    np.maximum.at(best, other, fit)
    smaller = (now <= size + sizes.slack(size)).all(axis=1)
    fit -= np.where(smaller, np.minimum(best[other], 0.0), 0.0)
    return np.asarray(found.records['hits'][other] * fit)


def _is_near(
    mean: Floats, cov: Floats, one: Indices, other: Indices, T: Floats, speed: Floats
) -> Bools:
    """Which pairs of tracks, (K,), need to be compared, one of them lost for T, (K,) [s]."""
    reach = np.hypot(mean[one, 2], mean[one, 3]) * T
    reach += REACH_SIGMAS * np.sqrt((cov[one, 0, 0] + cov[one, 1, 1]) / 2 + (speed.max() * T) ** 2)
    apart = mean[one, :2] - mean[other, :2]
    return np.asarray(np.hypot(apart[:, 0], apart[:, 1]) <= reach)


def log_likelihood_ratio(
    mean: Floats,
    cov: Floats,
    lost: Indices,
    found: Indices,
    chance: Floats,
    T: Floats,
    speed: Floats,
) -> Floats:
    """How likely tracks, with their velocities, continue others.

    :param mean, cov: (N, n) and (N, n, n) estimates of all tracks.
    :param lost: (K,) unmeasured tracks.
    :param found: (K,) tracks that have started since.
    :param chance: (K,) probability that the lost one has maneuvered.
    :param T: (K,) time in which it may have [s].
    :param speed: (2,) standard deviation of a new velocity on each axis [px/s].
    :return: (K,) log of the likelihood over that of any velocity, N(0, speed^2) [1/px^2].
    """
    one, P = mean[lost, :4], cov[lost, :4, :4]
    other, other_P = mean[found, :4], cov[found, :4, :4]
    turned_one, turned_P = turned(one, P, T, speed)
    log = _log_density(other - np.array([one, turned_one]), np.array([P, turned_P]) + other_P)
    log += np.log1p(-np.minimum(chance, ALMOST)), np.log(np.maximum(chance, TINY))
    any_S = speed**2 * np.eye(2) + other_P[:, 2:, 2:]
    return np.asarray(np.logaddexp(*log) - _log_density(other[:, 2:], any_S))


def _log_density(e: Floats, S: Floats) -> Floats:
    """Log of N(e; 0, S), (...), for (..., n) and (..., n, n)."""
    S = S * (1 + LOAD * np.eye(e.shape[-1]))
    d2 = (e * np.linalg.solve(S, e[..., None])[..., 0]).sum(axis=-1)
    return np.asarray(-0.5 * (d2 + np.linalg.slogdet(S)[1] + e.shape[-1] * LOG_2PI))
