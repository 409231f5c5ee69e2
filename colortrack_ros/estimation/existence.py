"""Whether an object exists, and whether it can be seen: a Markov chain and Bayes' rule.

Markov chain two of Musicki, Evans and Stankovic 1994 (integrated PDA): an object is visible, hidden
or gone, so that a hidden object does not stop existing by not being seen.
"""

from functools import lru_cache
import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

COVERED_EVERY = 10.0
"""Mean time until something covers a visible object [s]. Assumed; by the worlds of
benchmark/constants.py, half costs 1.0 points of IDF1 where objects vanish, 0.7 where blobs overlap,
twice gains 1.0 and 0.6, but ellipses of what coasts hold 68 % and not 89."""

GONE_EVERY = 100.0
"""Mean time until it vanishes in full view [s]. Assumed; disappearances replaces the ratio of the
two by what it has seen. Half and twice the value do what twice and half of the other do."""

HIDDEN_SHARE = GONE_EVERY / (GONE_EVERY + COVERED_EVERY)
"""Of what disappears, as far as these say."""

MOST_CHAINS = 8
"""Lengths of a step of which the chain is kept: see bank.MOST_STEPS."""


def predict_existence(
    visible: Floats, hidden: Floats, dt: float, longest: float
) -> tuple[Floats, Floats]:
    """Probabilities before the detections: objects get covered, vanish, and come out again.

    :param visible: (N,) probability that the object exists and can be seen.
    :param hidden: (N,) probability that it exists and cannot be seen.
    :param dt: [s].
    :param longest: that a track goes on unseen [s]; objects stay hidden for a third of it on
        average.
    :return: visible and hidden, (N,).
    """
    going_on, covered, returning, hiding = _transition(dt, longest)
    return visible * going_on + hidden * returning, hidden * hiding + visible * covered


@lru_cache(maxsize=MOST_CHAINS)
def _transition(dt: float, longest: float) -> tuple[float, float, float, float]:
    """From visible to visible and to hidden, from hidden to visible and to hidden."""
    returning = -math.expm1(-3 * dt / max(longest, 1e-3))
    covered, gone = -math.expm1(-dt / COVERED_EVERY), -math.expm1(-dt / GONE_EVERY)
    return 1 - covered - gone, covered, returning, 1 - returning


def update_existence(visible: Floats, hidden: Floats, ratio: Floats) -> tuple[Floats, Floats]:
    """Probabilities after the detections.

    :param visible: (N,), hidden: (N,) before them.
    :param ratio: (N,) likelihood of what was measured if the object is visible, over its
        likelihood if it is not.
    :return: visible and hidden, (N,).
    """
    total = 1 + visible * (ratio - 1)
    visible = np.minimum(visible * ratio / total, 1.0)
    return visible, np.minimum(hidden / total, 1 - visible)


def weigh_hidden(
    visible: Floats, hidden: Floats, share: Floats, last: Floats | float = HIDDEN_SHARE
) -> tuple[Floats, Floats]:
    """Probabilities of lost objects, once it is known better how many of those are hidden.

    :param visible: (N,), hidden: (N,) as the last share has them.
    :param share: (N,) of what is lost there that is hidden, in place of the last.
    :param last: (N,) what was taken for it so far; HIDDEN_SHARE for what has just been lost.
    :return: visible and hidden, (N,).
    """
    gone = np.maximum(1 - visible - hidden, 0.0) * (1 - share) / (1 - last)
    hidden = hidden * share / last
    total = np.maximum(visible + hidden + gone, 1e-300)
    return visible / total, hidden / total
