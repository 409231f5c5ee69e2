"""Tracks that have just been confirmed and are what has become of lost ones."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.association.gnn import associate
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.track_table import TrackTable

Indices = NDArray[np.intp]

FAR = 7.0
"""Nothing comes so many standard deviations away from where it may be expected."""


def reunions(
    tracks: TrackTable,
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
    T = (stamp - records['updated'][one]) / NANOSECONDS
    speed = config.initial_speed or learned.speed
    mean, cov = tracks.bank.estimate()
    reach = np.hypot(mean[one, 2], mean[one, 3]) * T
    reach += FAR * np.sqrt((cov[one, 0, 0] + cov[one, 1, 1]) / 2 + (speed * T) ** 2)
    apart = mean[one, :2] - mean[other, :2]
    near = np.hypot(apart[:, 0], apart[:, 1]) <= reach
    one, other, T = one[near], other[near], T[near]
    chance = learned.chance(T, period) * config.maneuvers
    gain = tracks.bank.resemblance(one, other, chance, T, speed)
    gain += np.log(np.maximum(records['hidden'][one], 1e-9))
    gain -= np.log(learned.birth_density(records['origin'][other], config.image_size))
    chosen, _ = associate(one, other, gain)
    return one[chosen], other[chosen]
