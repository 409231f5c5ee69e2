"""Nearest neighbor: each track takes its own best detection."""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices


def associate(track: Indices, detection: Indices, gain: Floats) -> tuple[Indices, Floats]:
    """Choose the best pair of each track, and the best track of each detection; see Associator.

    A track that loses its detection to another gets none.
    """
    order = np.flatnonzero(gain > 0)
    order = order[np.argsort(-gain[order], kind='stable')]
    order = order[np.unique(track[order], return_index=True)[1]]
    order = order[np.argsort(-gain[order], kind='stable')]
    pairs = np.sort(order[np.unique(detection[order], return_index=True)[1]])
    return pairs, np.ones(len(pairs))
