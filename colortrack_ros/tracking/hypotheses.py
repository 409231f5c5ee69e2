"""Hypotheses: which blob may be the measurement of which track."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Columns
from colortrack_ros.estimation.bank import Innovations

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Hypotheses(Columns):
    """K pairs of a track and a blob, ascending by track.

    :param track: (K,).
    :param blob: (K,).
    :param z: (K, 2) what the blob measures of the track's position [px].
    :param R: (K, 2, 2) its covariance [px^2].
    :param innovations: (K,) how z compares with what was predicted.
    """

    track: Indices
    blob: Indices
    z: Floats
    R: Floats
    innovations: Innovations
