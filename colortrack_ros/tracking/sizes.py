"""Sizes: whether a blob has the size of an object, and how significant that is."""

import math

import numpy as np

from colortrack_ros.data import Floats

# Constants marked "assumed" were set by hand; benchmark/ablation.py --constants sizes.NAME shows
# what IDF1 becomes with half and twice the value.

TOLERANCE = 2.0
"""Largest difference in size at which a box is complete [px]: each side is rounded to a whole
pixel, and may come out as the next one."""

TOLERANCE_SHARE = 0.05
"""Additional share of the size that a complete box may differ by. Assumed: an object turns and
bends by a twentieth."""

OTHER_SIZE = 0.02
"""Probability that a blob has another size than its object. Assumed: one in 50, as for colors."""


FIRST_ALIKE, ALIKE_SHARE = 0.1, 0.03
"""Initial share of unassociated blobs that have the size of some track, and the weight of one more
blob in it. Assumed."""

FIRST_COMPARED = 3
"""Blobs that the initial share is worth. Assumed."""

JITTER_MEMORY = 10.0
"""Time after which a change of size has decayed to 1/e [s]. Assumed: as for noise.NOISE_MEMORY."""

JITTER_PRIOR = 10.0
"""Weight, in changes of size, of the initial assumption that boxes do not jitter. Assumed."""

LOOSE_SIGMA = 2.5
"""Standard deviations of a jittering size within the slack: 99 % of normal ones are."""

MEAN_LOG_SQUARE = -1.2703628
"""Mean of ln x^2 for a standard normal x: minus Euler's constant, minus ln 2. A mean of logs is
robust against the few boxes that are cut or merged."""

LEAST_CHANGE = 0.1
"""Least change of size, in tolerances, for a box that stays exactly the same. Assumed."""

FEWEST_SIZES = 2
"""Number of sizes from which on they say who is near and who is far. One has nothing to compare."""


def total(extent: Floats) -> Floats:
    """Return the sizes, (K, 2), of extents, (K, 2, 2): from the low to the high side [px]."""
    size: Floats = extent[:, 0] + extent[:, 1]
    return size


def both_ways(size: Floats) -> Floats:
    """Return for each axis the sizes, (K, 2), on it and on the other one, (K, 2, 2)."""
    return np.asarray(np.stack([size, size[:, ::-1]], axis=2))


def nearness(size: Floats) -> Floats | None:
    """Return sizes over the root mean square of all, (N, 1), at most 1; None for fewer than two.

    What is complete and looks smaller than others is farther away, and so it looks slower.

    :param size: (N, 2) [px], 0 where unknown, which counts as near.
    """
    area = size[:, 0] * size[:, 1]
    known = area > 0
    count = np.count_nonzero(known)
    if count < FEWEST_SIZES:
        return None
    near = np.where(known, np.sqrt(area * count / area.sum()), 1.0)
    return np.minimum(near, 1.0)[:, None]


def tolerance(size: Floats) -> Floats:
    """Return how much the size of a steady box may differ from the object's size [px]."""
    return TOLERANCE + TOLERANCE_SHARE * size


def log_fit(excess: Floats, slack: Floats, best: Floats) -> Floats:
    """Return the log-likelihood ratio of sizes; see Sizes.log_fit().

    :param excess: (K, 2) sizes of the blobs minus those of the objects [px].
    :param slack: (K, 2) see Sizes.slack() [px].
    :param best: (K,) see Sizes.most_fitting().
    """
    e = excess / slack
    e *= e
    d2 = e[:, 0] + e[:, 1]
    return np.asarray(np.log(OTHER_SIZE + np.exp(best - d2 / 2.0)))


class Sizes:
    """Learns how similar sizes are: those of one object's boxes, and those of other blobs.

    The boxes of a network jitter from frame to frame, those of an outline by a pixel.

    :ivar alike: share of the unassociated blobs that have the size of some track.
    :ivar jitter: standard deviation of a box's size over its tolerance; 0 while nothing is known.
    """

    def __init__(self) -> None:
        self.alike, self.jitter = FIRST_ALIKE, 0.0
        self._compared = FIRST_COMPARED
        self.looseness = 1.0
        """Ratio of slack to tolerance, at least 1."""
        self._changes, self._log_sum = 0.0, 0.0

    @property
    def are_steady(self) -> bool:
        """Whether boxes jitter by no more than the tolerance."""
        return self.looseness == 1

    def slack(self, size: Floats) -> Floats:
        """Return how much the size of a complete blob may differ from the object's size [px]."""
        return tolerance(size) if self.are_steady else self.looseness * tolerance(size)

    def variance(self, size: Floats) -> Floats:
        """Return the variance of the sizes of an object's boxes [px^2]."""
        return (self.jitter * tolerance(size)) ** 2

    def difference(self, size: Floats, blob: Floats) -> Floats:
        """Return the size of the blob minus that of the object, 0 within the slack.

        :param size: (K, 2) of the object [px].
        :param blob: (K, 2) of the blob [px].
        :return: (K, 2) [px], negative for a blob that is cut.
        """
        excess = blob - size
        return np.where(np.abs(excess) > self.slack(size), excess, 0.0)

    def log_fit(self, size: Floats, blob: Floats) -> Floats:
        """Return the log-likelihood ratio of blob sizes: of these objects, against any other.

        An object's own blob differs by the slack, and one in 50 by anything. Other blobs are alike,
        or up to twice as large.

        :param size: (K, 2) of the object [px].
        :param blob: (K, 2) of the blob [px].
        :return: (K,).
        """
        slack = self.slack(size)
        return log_fit(blob - size, slack, self.most_fitting(size, slack))

    def most_fitting(self, size: Floats, slack: Floats) -> Floats:
        """Return the log-likelihood ratio of an exact fit, (K,), at least 0; see log_fit()."""
        share = slack / np.maximum(size, 1.0)
        broad = np.pi / 2 * (share[:, 0] * share[:, 1])
        best: Floats = np.log(np.maximum((1 - OTHER_SIZE) / (self.alike + broad), 1.0))
        return best

    def learn_alike(self, size: Floats, new: Floats) -> None:
        """Learn from some unassociated blobs, (K, 2) [px], given the objects, (N, 2) [px]."""
        same = np.abs(new[:, None] - size) <= self.slack(size)
        alike = int(np.count_nonzero((same[..., 0] & same[..., 1]).any(axis=1)))
        self._compared += len(new)
        share = max(-math.expm1(-ALIKE_SHARE * len(new)), len(new) / self._compared)
        self.alike += share * (alike / len(new) - self.alike)

    def learn_jitter(self, last: Floats, size: Floats, period: float) -> None:
        """Learn from boxes of objects that were measured in the last frame, too.

        :param last, size: (K, 2) in the last frame and in this one [px].
        :param period: since boxes were last learned from [s].
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
