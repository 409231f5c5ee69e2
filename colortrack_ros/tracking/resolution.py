"""Resolution: the distance at which a detector merges two objects into one detection."""

import numpy as np
from scipy.spatial import cKDTree

from colortrack_ros.data import Floats
from colortrack_ros.tracking.recent import EVERY

RADII = np.geomspace(1.0, 200.0, 24)
"""Radii that are compared [px]: from a pixel to objects that fill a third of a picture."""

STEEPNESS = 4
"""Exponent of the distance in the probability. Objects of one size all merge at one distance, those
of two sizes at several. Assumed; 2, as in the source, and 8 change IDF1 of merging points by a
point."""

BY_CHANCE = 1e-3
"""Share of apparent mergers, at any distance, that are none. Assumed."""

MOST_BESIDE = 8
"""Neighbors of each detection whose distances are counted, to bound the time. Assumed."""

PRIOR_LOG_ODDS = 5.0
"""Initial log odds of the smallest radius against any other. A merger in clutter is then not
believed before it is known how close resolved objects get. Assumed; without it 40 objects among as
many false detections lose up to 10 points of IDF1."""

POSSIBLE = 1e-3
"""Probability below which a radius is ruled out. Assumed."""

LEFT = 0.99
"""Share of evidence and counts kept at each look: a memory of 500 frames. Assumed."""


class Resolution:
    """Learns r: objects at a distance d are unresolved with probability exp(-(d/r)^4).

    (After Koch and van Keuk 1997, who have a square there.)

    :ivar reach: largest distance of an object from the mean of those that it merges with [px].
    """

    def __init__(self) -> None:
        self._log = np.zeros(len(RADII))
        self._frame = 0
        self._conclude()

    def _conclude(self) -> None:
        log_weight = self._log + PRIOR_LOG_ODDS * (RADII[0] == RADII)
        weight = np.exp(log_weight - log_weight.max())
        self._weight = weight / weight.sum()
        self.reach = 1.5 * float(RADII[self._weight > POSSIBLE].max())

    def log_chance(self, apart: Floats) -> Floats:
        """Return the log of the probability that objects at distances apart [px] are unresolved."""
        return np.asarray(np.log(np.maximum(_chance(apart) @ self._weight, 1e-300)))

    def learn(self, z: Floats, apart: Floats) -> None:
        """Learn, every few frames, from distances between objects.

        :param z: (K, 2) detections of resolved objects [px].
        :param apart: (J,) distances between unresolved ones [px].
        """
        self._frame += 1
        if self._frame % EVERY or len(z) + len(apart) < 2:
            return
        found = cKDTree(z).query(z, MOST_BESIDE + 1, distance_upper_bound=RADII[-1])[0][:, 1:]
        found = found[np.isfinite(found)]
        self._log *= LEFT
        if len(found):
            place = np.searchsorted(EDGES, found)
            self._log += np.bincount(place, minlength=len(EDGES) + 1) @ RESOLVED / 2
        if len(apart):
            self._log += np.log(BY_CHANCE + (1 - BY_CHANCE) * _chance(apart)).sum(axis=0)
        self._conclude()


def _chance(apart: Floats) -> Floats:
    """Return the probability, (..., G), of being unresolved at distances (...) [px], by radius."""
    return np.asarray(np.exp(-((apart[..., None] / RADII) ** STEEPNESS)))


EDGES = np.geomspace(RADII[0], RADII[-1], 2 * len(RADII))
"""Edges of the bins in which distances are counted [px]."""

RESOLVED = np.log(BY_CHANCE + (1 - BY_CHANCE) * (1 - _chance(np.append(EDGES[0] / 2, EDGES))))
"""Log-likelihood of a resolved pair in each bin, by radius."""
