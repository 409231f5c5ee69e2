"""Nearest neighbor: each track takes the detection that is best for itself."""

import numpy as np

from colortrack_ros.tracking.association.base import Floats
from colortrack_ros.tracking.association.base import Indices


def associate(track: Indices, detection: Indices, gain: Floats) -> tuple[Indices, Floats]:
    """Choose for each track its best pair, and of tracks at one detection the best; see Associator.

    A track that has lost its detection to another gets none.
    """
    order = np.flatnonzero(gain > 0)
    order = order[np.argsort(-gain[order], kind='stable')]
    order = order[np.unique(track[order], return_index=True)[1]]
    order = order[np.argsort(-gain[order], kind='stable')]
    pairs = np.sort(order[np.unique(detection[order], return_index=True)[1]])
    return pairs, np.ones(len(pairs))
