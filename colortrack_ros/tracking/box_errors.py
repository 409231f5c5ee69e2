"""Errors of boxes that last: a network that draws a box too far left does so for seconds.

The object's motion hides such errors of its center, whose variance therefore seems to be that of
what changes from frame to frame alone. But they are errors of its sides, so they show in its size,
which hardly changes by itself: second differences of sizes are larger over five frames than over
one, where white errors have the same in both, and smooth changes far larger ones over five.
"""

import math

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.tracking.recent import EVERY
from colortrack_ros.tracking.recent import SEEN_SIZE
from colortrack_ros.tracking.recent import WHOLE
from colortrack_ros.tracking.recent import Z

WHOLE_PIXEL = 1.0
"""Added to squared differences [px^2]: sizes of whole pixels say nothing below that."""

LEAST_SIZE_JITTER = 1.2
"""Least mean log of (1 + squared differences), one frame apart. Sizes that are rounded to whole
pixels have up to 1.1 by that alone, and last or not as objects come nearer."""

SPACINGS = 1, 5
"""Spacings of second differences [frames]."""

EXCESSES = np.append(0.0, np.linspace(0.2, 4.0, 39))
"""Mean log ratios of their squares that are compared: 0 for white errors. Of 45 sequences of people
and cars, as found by four public detectors, most have 0.2 to 1.7."""

MOST_EXCESS = 2.0
"""Largest one that is an error's; beyond it the sizes themselves change. Assumed."""

WHITE_ERRORS = np.array([1 / 2, 1 / 47])
"""Prior probability of white errors, of boxes of any origin (assumed: as likely as others) and of a
network's: of those 45 sequences none had them (rule of succession)."""

ERRING = np.stack([(EXCESSES > 0) & (EXCESSES <= MOST_EXCESS), EXCESSES > 0])
"""Which EXCESSES are of errors that last, by origin. Sizes that change by themselves hide them, but
a network errs all the same."""

EXCESS_PRIOR = np.where(
    EXCESSES > 0, (1 - WHITE_ERRORS[:, None]) / np.count_nonzero(EXCESSES), WHITE_ERRORS[:, None]
)
"""Prior probabilities of EXCESSES, by origin."""

UNTOLD = 0.0, 1 - WHITE_ERRORS[1]
"""BoxErrors.lasting while sizes tell nothing: a network's errors last by the prior alone."""

EXCESS_VARIANCE = 3.4
"""Variance of a log ratio per pair of differences. Found by drawing long series of white normal
errors, since pairs share sizes."""

LEAST_EXCESS_VARIANCE = 0.05**2
"""Least variance of the mean of many: errors are not quite normal. Assumed."""


class BoxErrors:
    """Learns whether the errors of boxes last, and how far their centers are then off.

    :ivar lasting: probability that they last, times the share of them that moves centers: of boxes
        of any origin, and of a network's.
    """

    def __init__(self) -> None:
        self.lasting = UNTOLD
        self._pairs, self._jitter, self._excess = 0, np.zeros(2), np.zeros(2)

    def learn(self, measured: Floats) -> None:
        """Learn from the last frames of tracks, (K, RING, columns), the newest first."""
        both = np.stack([measured[..., SEEN_SIZE], 2 * measured[..., Z]], axis=2)
        whole = measured[..., WHOLE] > 0
        known, logs = np.ones((len(measured), EVERY), bool), []
        for apart in SPACINGS:
            new, mid, old = (slice(k * apart, k * apart + EVERY) for k in range(3))
            known &= whole[:, new] & whole[:, mid] & whole[:, old]
            difference = both[:, new] - 2 * both[:, mid] + both[:, old]
            logs.append(np.log((difference**2).mean(axis=3) + WHOLE_PIXEL))
        self._pairs += np.count_nonzero(known)
        self._jitter += logs[0][known].sum(axis=0)
        self._excess += (logs[1] - logs[0])[known].sum(axis=0)
        self.lasting = UNTOLD
        if self._jitter[0] > LEAST_SIZE_JITTER * self._pairs:
            (of_size, of_center), excess = self._jitter / self._pairs, self._excess / self._pairs
            variance = EXCESS_VARIANCE / self._pairs + LEAST_EXCESS_VARIANCE
            d2 = (excess.min() - EXCESSES) ** 2 / variance
            weight = EXCESS_PRIOR * np.exp((d2.min() - d2) / 2)
            share = min(math.exp(of_center - of_size), 1.0)
            any_origin, network = share * (weight * ERRING).sum(axis=1) / weight.sum(axis=1)
            self.lasting = float(any_origin), float(network)
