"""Traffic: most objects enter and leave the picture over its border; few appear within it.

Detectors miss what the border cuts, and what they look at may end before the picture does. So those
that enter are detected first at some depth, and those that leave are lost some time before.
"""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.estimation.existence import DISAPPEARING
from colortrack_ros.estimation.gaussian import TINY

NEAR_BORDER = 0.19
"""Mean share of the picture that is nearer to the border than where objects that enter are detected
first: a border as wide as a twentieth of the picture covers as much. Assumed."""

ENTERING, FEW_PLACES = 0.9, 10.0
"""Prior share of new objects that enter, and its weight in objects. Assumed."""

LEFT_BEFORE = 1.0
"""Mean time before the border at which objects that leave are detected last [s]. Assumed; with a
hazard of 1 over the time that is left instead, IDF1 of ten sets of pedestrians changes by 2 points
at most."""


class Entrances:
    """Learns how many of the new objects enter over the border; the others appear anywhere."""

    def __init__(self) -> None:
        self._entered, self._appeared = FEW_PLACES * ENTERING, FEW_PLACES * (1 - ENTERING)

    def learn(self, z: Floats, low: Floats, high: Floats) -> None:
        """Add new objects by where each was first measured, see density()."""
        entered = self._entered * _entering_density(z, low, high)
        total = float((entered / (entered + self._appeared)).sum())
        self._entered += total
        self._appeared += len(z) - total

    def density(self, z: Floats, low: Floats, high: Floats) -> Floats:
        """Density of new objects at z, (K, 2) [px], over that of as many anywhere: (K,).

        :param low, high: (2,) corners of the picture [px].
        """
        both = self._entered * _entering_density(z, low, high) + self._appeared
        return np.asarray(both / (self._entered + self._appeared))


def _entering_density(z: Floats, low: Floats, high: Floats) -> Floats:
    """The same, (K,), of those that enter, by the exponential distribution of NEAR_BORDER."""
    middle = np.abs(2 * z - low - high) / np.maximum(high - low, TINY)  # 0 there, 1 at the border
    nearer = 1 - np.minimum(middle.max(axis=1), 1.0) ** 2
    return np.asarray(np.exp(-nearer / NEAR_BORDER) / (-np.expm1(-1 / NEAR_BORDER) * NEAR_BORDER))


def leaving_rate(seen: Floats, velocity: Floats, image_size: tuple[int, int]) -> Floats:
    """Rate, (N,) [1/s], at which detected objects leave that are where these were last measured.

    The time that they have left to the border is distributed exponentially.

    :param seen: (N, 2) [px]; velocity: (N, 2) [px/s].
    :param image_size: of the picture [px]; 0 if unknown, and then so is what leaves: 0.
    """
    if not all(image_size):
        return np.zeros(len(seen))
    way = np.maximum(np.where(velocity > 0, np.array(image_size) - seen, seen), 0.0)
    ahead = (way / np.maximum(np.abs(velocity), TINY)).min(axis=1)
    return np.asarray(np.exp(-ahead / LEFT_BEFORE) / LEFT_BEFORE)


def share_staying(share: Floats, leaving: Floats | float) -> Floats:
    """Share, (N,), of the lost objects that are hidden in the picture, given where each was going.

    What hides is lost anywhere on its way.

    :param share: (N,) of those that are hidden among all that are lost there.
    :param leaving: (N,) see leaving_rate().
    """
    return np.asarray(share / (1 + (1 - share) * leaving / DISAPPEARING))
