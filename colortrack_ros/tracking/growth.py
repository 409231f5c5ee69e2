"""Growth: how fast objects that approach, recede or turn change their size in the picture.

Both of their sides move, apart or together. Of an object that is cut, or merged with another, only
one side moves, so the side that moves less shows how much is growth.
"""

import math

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.records import Records

FOLLOWING_SHARE = 0.2
"""Weight of a complete blob's size in the learned size: a memory of five frames. Assumed."""

GROWTH_SHARE = FOLLOWING_SHARE**2 / (2 - FOLLOWING_SHARE)
"""Weight of a blob's difference in size in the learned growth: beta = alpha^2 / (2 - alpha)
(Benedict and Bordner 1962)."""

SCALING_SHARE = 0.1
"""The same for a blob that differs by one factor on both axes, beyond the tolerance: more, as its
sides say it four times, but one sudden change shall not look like growth. Assumed: with 0.022 the
RMSE of the scene `red_object` is 0.23 instead of 0.17 px, with 0.4 0.22, and ellipses of `worlds
"behind covers, smaller"` hold 82 instead of 87 %."""

STEADY_SIDE = 0.5
"""Sides this close to their prediction say nothing about growth, unless the object has grown before
[px]: boxes consist of whole pixels. With half of it the scene `swarm` loses 0.8 points of IDF1."""

FASTEST_GROWTH = 1.5
"""Bound of the growth of an object [1/s]: it would reach the camera in 0.7 s. Assumed: growth by
3 % a frame, which has to be followed, is 0.9."""

GROWTH_TIME = 0.1
"""Time constant with which growth decays while unseen, cut or merged [s]. Assumed: half and twice
change nothing in `collision`, `swarm` and `vanish`."""


def grow(records: Records, unmeasured: Floats, dt: float) -> None:
    """Predict the extents of tracks.

    :param records: (N,) of all tracks, see records.FIELDS.
    :param unmeasured: (N,) time since each was measured [s].
    :param dt: since the last message [s].
    """
    growth = records['growth']
    if dt > 0 and np.count_nonzero(growth):
        records['extent'] *= np.exp(growth * _lasting(dt))[:, None]
        growth[unmeasured > dt] *= math.exp(-dt / GROWTH_TIME)


def learn_growth(
    records: Records, track: Indices, moved: Floats, cut: Bools, odd: Bools, period: float
) -> None:
    """Learn from the sides of blobs.

    :param records: (N,) of all tracks, see records.FIELDS.
    :param track: (K,) which were measured, each once.
    :param moved: (K, 2, 2) how far the low and the high side are outside their predictions, by
        axis [px].
    :param cut: (K, 2) by axis: whether a side is not the object's own.
    :param odd: (K,) whether it has another size, or is mixed with others.
    :param period: since the last frame [s].
    """
    before = records['growth'][track]
    margin = STEADY_SIDE * (before == 0)
    least, most = np.minimum(moved[:, 0], moved[:, 1]), np.maximum(moved[:, 0], moved[:, 1])
    both = 2 * (np.maximum(least - margin, 0.0) + np.minimum(most + margin, 0.0))
    both[cut | odd[:, None]] = 0.0
    extent, hits = records['extent'][track], records['hits'][track] + 1.0
    share = np.maximum(6 / (hits * (hits + 1)), GROWTH_SHARE)[:, None]  # first of a growing memory
    change = share * both / np.maximum(extent[:, 0] + extent[:, 1], 1.0) / _lasting(period)
    change += np.where(odd[:, None], math.expm1(-period / GROWTH_TIME) * before, 0.0)
    records['growth'][track] = (before + change).clip(-FASTEST_GROWTH, FASTEST_GROWTH)


def learn_scaling(records: Records, track: Indices, excess: Floats, period: float) -> None:
    """Learn from blobs that are larger or smaller than predicted by one factor on both axes.

    :param records: (N,) of all tracks, see records.FIELDS.
    :param track: (K,) which were measured, each once.
    :param excess: (K, 2) of the sizes [px].
    :param period: since the last frame [s].
    """
    extent = records['extent'][track]
    factor = np.log1p(excess / (extent[:, 0] + extent[:, 1])).mean(axis=1, keepdims=True)
    growth = records['growth'][track].mean(axis=1, keepdims=True)
    growth += SCALING_SHARE * factor / _lasting(period)
    records['growth'][track] = growth.clip(-FASTEST_GROWTH, FASTEST_GROWTH)


def _lasting(dt: float) -> float:
    """Effective duration within dt of growth that decays with GROWTH_TIME [s]."""
    return -GROWTH_TIME * math.expm1(-dt / GROWTH_TIME)
