"""Sizes: whether a blob has the size of an object, and how much that tells."""

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Constants marked "assumed" were set by hand; benchmark/ablation.py --constants sizes.NAME shows
# what IDF1 becomes with half and twice the value.

TOLERANCE = 2.0
"""A box is whole when its size differs by no more than this [px]: each side is a whole pixel, and
may be the next one."""

TOLERANCE_SHARE = 0.05
"""And by no more than this share beyond. Assumed: an object turns and bends by a twentieth."""

OTHER_SIZE = 0.02
"""Probability that a blob has another size than its object. Assumed: one in 50, as for colors."""


FIRST_ALIKE, ALIKE_SHARE = 0.1, 0.03
"""Share of the blobs of no track that have the size of one, to start from, and the share of one
more blob in it. Assumed."""

JITTER_MEMORY = 10.0
"""Time after which the change of a box counts 1/e [s]. Assumed: as for noise.NOISE_MEMORY."""

JITTER_PRIOR = 10.0
"""Changes that a jitter which the tolerance holds is worth. Assumed."""

LOOSE_SIGMA = 2.5
"""Standard deviations of a jittering size that are within the slack: 99 % of the normal ones."""

MEAN_LOG_SQUARE = -1.2703628
"""Mean of ln x^2 for x of a normal distribution of variance 1: minus Euler's constant, minus ln 2.
A mean of logarithms is hardly moved by the few boxes that are cut or merged."""

LEAST_CHANGE = 0.1
"""Of a size, in tolerances: of a box that stays as it is to the bit. Assumed."""


def total(extent: Floats) -> Floats:
    """(K, 2) sizes of extents, (K, 2, 2): from the low to the high side [px]."""
    return np.asarray(extent[:, 0] + extent[:, 1])


def tolerance(size: Floats) -> Floats:
    """How much the size of a steady box may differ from the object's size [px]."""
    return TOLERANCE + TOLERANCE_SHARE * size


def log_fit(excess: Floats, slack: Floats, best: Floats) -> Floats:
    """See Sizes.log_fit().

    :param excess: (K, 2) size of the blobs beyond that of the objects [px].
    :param slack: (K, 2) see Sizes.slack() [px].
    :param best: (K,) see Sizes.most_fitting().
    """
    e = excess / slack
    e *= e
    d2 = e[:, 0] + e[:, 1]
    return np.asarray(np.log(OTHER_SIZE + np.exp(best - d2 / 2)))


class Sizes:
    """How alike sizes are, learned: those of one object's boxes, and those of other blobs.

    The boxes of a network jitter with each frame, those of an outline by a pixel.

    :ivar alike: share of the blobs of no track that have the size of one.
    :ivar jitter: standard deviation of a box's size over its tolerance; 0 while it tells nothing.
    """

    def __init__(self) -> None:
        self.alike, self.jitter = FIRST_ALIKE, 0.0
        self.looseness = 1.0
        """What slack is over the tolerance, at least 1."""
        self._changes, self._log_sum = 0.0, 0.0

    @property
    def are_steady(self) -> bool:
        """Whether boxes jitter by no more than the tolerance."""
        return self.looseness == 1

    def slack(self, size: Floats) -> Floats:
        """How much the size of a whole blob may differ from the object's size [px]."""
        return tolerance(size) if self.are_steady else self.looseness * tolerance(size)

    def variance(self, size: Floats) -> Floats:
        """Of the sizes of an object's boxes [px^2]."""
        return (self.jitter * tolerance(size)) ** 2

    def difference(self, size: Floats, blob: Floats) -> Floats:
        """Size of the blob beyond the object's, 0 within the slack.

        :param size: (K, 2) of the object [px].
        :param blob: (K, 2) of the blob [px].
        :return: (K, 2) [px], negative for a blob that is cut.
        """
        excess = blob - size
        return np.where(np.abs(excess) > self.slack(size), excess, 0.0)

    def log_fit(self, size: Floats, blob: Floats) -> Floats:
        """Log-likelihood ratio of blobs' sizes: of these objects, against of any other.

        An object's own blob differs by a slack, one in 50 by anything. Others are alike, or up to
        twice as large.

        :param size: (K, 2) of the object [px].
        :param blob: (K, 2) of the blob [px].
        :return: (K,).
        """
        slack = self.slack(size)
        return log_fit(blob - size, slack, self.most_fitting(size, slack))

    def most_fitting(self, size: Floats, slack: Floats) -> Floats:
        """Log-likelihood ratio, at least 0, of a blob of just that size, (K, 2); see log_fit()."""
        share = slack / np.maximum(size, 1.0)
        broad = np.pi / 2 * (share[:, 0] * share[:, 1])
        return np.asarray(np.log(np.maximum((1 - OTHER_SIZE) / (self.alike + broad), 1.0)))

    def learn_alike(self, size: Floats, new: Floats) -> None:
        """Take some blobs of no track, (K, 2) [px], beside the objects, (N, 2) [px]."""
        same = np.abs(new[:, None] - size) <= self.slack(size)
        alike = int(np.count_nonzero((same[..., 0] & same[..., 1]).any(axis=1)))
        self.alike += -math.expm1(-ALIKE_SHARE * len(new)) * (alike / len(new) - self.alike)

    def learn_jitter(self, last: Floats, size: Floats, period: float) -> None:
        """Take boxes of objects that were measured in the last frame as well.

        :param last, size: (K, 2) then and now [px].
        :param period: since such were taken last [s].
        """
        if not len(last):
            return
        change = np.maximum(np.abs(size - last) / tolerance(last), LEAST_CHANGE)
        left = math.exp(-period / JITTER_MEMORY)
        self._changes = left * self._changes + change.size
        self._log_sum = left * self._log_sum + float(np.log(change).sum())
        log_variance = 2 * self._log_sum / self._changes - MEAN_LOG_SQUARE - math.log(2)
        share = self._changes / (self._changes + JITTER_PRIOR)
        self.jitter = share * math.exp(log_variance / 2)
        self.looseness = max(1.0, LOOSE_SIGMA * self.jitter)
