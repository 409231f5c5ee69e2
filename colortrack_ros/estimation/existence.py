"""Existence and visibility of objects: a Markov chain and Bayes' rule.

Markov chain two of Musicki, Evans and Stankovic 1994 (integrated PDA): an object is visible, hidden
or gone, so that missing detections of a hidden object do not end its existence.
"""

from functools import lru_cache
import math

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.estimation.gaussian import TINY

COVERED_EVERY = 10.0
"""Mean time until a visible object is occluded [s]. Assumed. In the worlds of
benchmark/constants.py, half of it costs 1.0 points of IDF1 where objects vanish and 0.7 where blobs
overlap; twice gains 1.0 and 0.6, but ellipses of coasting tracks hold 68 % instead of 89."""

GONE_EVERY = 100.0
"""Mean time until an object vanishes in full view [s]. Assumed; disappearances learns the ratio of
the two. Halving it acts like doubling COVERED_EVERY, and the reverse."""

CALM_PERIOD = 1.0
"""Frame period above which objects are taken to be occluded and to vanish more seldom in proportion
[s]: whoever looks that seldom watches what lasts. Assumed. With half of it, IDF1 of players seen
once a second is 2 points lower; with twice, of aircraft seen every 4 and 10 s 4 points."""

HIDDEN_SHARE = GONE_EVERY / (GONE_EVERY + COVERED_EVERY)
"""Share of disappearing objects that are hidden, by these two times."""

DISAPPEARING = 1 / GONE_EVERY + 1 / COVERED_EVERY
"""Rate at which a visible object gets out of sight [1/s]."""

MOST_CHAINS = 8
"""Step lengths whose transition probabilities are cached: see bank.MOST_STEPS."""


def predict_existence(
    visible: Floats, hidden: Floats, dt: float, longest: float, calm: float = 1.0
) -> tuple[Floats, Floats]:
    """Predict the probabilities: objects get occluded, vanish, and reappear.

    :param visible: (N,) probability that the object exists and can be seen.
    :param hidden: (N,) probability that it exists and cannot be seen.
    :param dt: [s].
    :param longest: time that a track may coast [s]; objects stay hidden for a third of it on
        average.
    :param calm: how many times more seldom they get occluded, and vanish.
    :return: visible and hidden, (N,).
    """
    going_on, covered, returning, hiding = _transition(dt, longest, calm)
    return visible * going_on + hidden * returning, hidden * hiding + visible * covered


@lru_cache(maxsize=MOST_CHAINS)
def _transition(dt: float, longest: float, calm: float) -> tuple[float, float, float, float]:
    """Probabilities of visible to visible and to hidden, and of hidden to visible and to hidden."""
    returning = -math.expm1(-3 * dt / max(longest, 1e-3))
    gone = -math.expm1(-dt / (calm * GONE_EVERY))
    covered = -math.expm1(-dt / (calm * COVERED_EVERY))
    covered = min(covered, 1 - gone)  # in a long time it may be both
    return max(1 - covered - gone, TINY), covered, returning, 1 - returning


def update_existence(visible: Floats, hidden: Floats, ratio: Floats) -> tuple[Floats, Floats]:
    """Update the probabilities by Bayes' rule.

    :param visible: (N,), hidden: (N,) predicted.
    :param ratio: (N,) likelihood of the measurements if the object is visible, over their
        likelihood if it is not.
    :return: visible and hidden, (N,).
    """
    total = 1.0 + visible * (ratio - 1.0)
    visible = np.minimum(visible * ratio / total, 1.0)
    return visible, np.minimum(hidden / total, 1.0 - visible)


def weigh_hidden(
    visible: Floats, hidden: Floats, share: Floats, last: Floats | float = HIDDEN_SHARE
) -> tuple[Floats, Floats]:
    """Recompute the probabilities of lost objects for a new estimate of the hidden share.

    :param visible: (N,), hidden: (N,) computed with the last share.
    :param share: (N,) share of the objects lost there that are hidden.
    :param last: (N,) the share used so far; HIDDEN_SHARE for objects just lost.
    :return: visible and hidden, (N,).
    """
    gone = np.maximum(1.0 - visible - hidden, 0.0) * (1.0 - share) / (1.0 - last)
    hidden = hidden * share / last
    total = np.maximum(visible + hidden + gone, 1e-300)
    return visible / total, hidden / total
