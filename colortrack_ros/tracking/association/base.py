"""Associator: what every associator takes and returns."""

from typing import Protocol

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices


class Associator(Protocol):
    """Decides among candidate pairs."""

    def __call__(self, track: Indices, detection: Indices, gain: Floats) -> tuple[Indices, Floats]:
        """Choose pairs.

        :param track: (K,) track of each candidate pair, ascending.
        :param detection: (K,) detection of each candidate pair.
        :param gain: (K,) log-likelihood ratio of the pair against leaving both unassociated.
        :return: indices of the chosen pairs, ascending, and the probability that each is correct,
            which is 1 for hard decisions.
        """
