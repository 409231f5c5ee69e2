"""Global nearest neighbor: the assignment of greatest total gain (the Hungarian method)."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment


def associate(
    track: NDArray[np.intp], detection: NDArray[np.intp], gain: NDArray[np.float64]
) -> NDArray[np.intp]:
    """Choose the pairs with the greatest sum of gains; see Associator.

    A pair that is no candidate has gain 0, which is what a miss is worth.
    """
    tracks, row = np.unique(track, return_inverse=True)
    detections, column = np.unique(detection, return_inverse=True)
    pair = np.full((len(tracks), len(detections)), -1)
    table = np.zeros(pair.shape)
    pair[row, column] = np.arange(len(track))
    table[row, column] = gain
    chosen = pair[linear_sum_assignment(table, maximize=True)]
    return np.sort(chosen[chosen >= 0])
