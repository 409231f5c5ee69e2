"""Disappearances: where objects that were lost have come back, and where they have not."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.estimation.existence import HIDDEN_SHARE

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

REMEMBERED = 200
"""How many of the last are kept: at one a second those of three minutes."""

BESIDE = 30.0
"""How far the place of another tells of a cover [px]: its weight is 61 % there. Assumed."""

ANYWHERE_WEIGHT = 2.0
"""Of each kind so many may have been anywhere in the picture. Assumed."""


class Disappearances:
    """Learns from tracks that were lost what has become of them."""

    def __init__(self) -> None:
        self._place = np.zeros((0, 2))
        self._returned = np.zeros(0)

    def learn(self, place: Floats, *, returned: bool) -> None:
        """Take tracks that have come back, or have not in their time.

        :param place: (K, 2) where each was measured before [px].
        """
        if not len(place):
            return
        self._place = np.concatenate([self._place, place])[-REMEMBERED:]
        some = np.full(len(place), float(returned))
        self._returned = np.concatenate([self._returned, some])[-REMEMBERED:]

    def share(self, place: Floats, area: float) -> Floats:
        """Probability, (K,), that what has just been lost is hidden and not gone.

        By the densities of both kinds, each a sum of kernels and a few anywhere: a cover hides what
        comes there, again and again; where none is known, many that returned elsewhere say little.

        :param place: (K, 2) where each was measured [px].
        :param area: of the picture [px^2].
        """
        d2 = ((place[:, None] - self._place) ** 2).sum(axis=2) / BESIDE**2
        weight = np.exp(-d2 / 2) / (2 * np.pi * BESIDE**2)
        density = []
        for share, kind in ((HIDDEN_SHARE, self._returned), (1 - HIDDEN_SHARE, 1 - self._returned)):
            count = float(kind.sum())
            anywhere = ANYWHERE_WEIGHT * (count + share) / (count + 1) / area
            density.append(weight @ kind + anywhere)
        returned, gone = density
        return np.asarray(returned / (returned + gone))
