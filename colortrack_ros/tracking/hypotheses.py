"""Pairs of a track and a blob that may be its own."""

from dataclasses import dataclass
from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Pairs:
    """K pairs, ascending by track.

    :param track: (K,).
    :param blob: (K,).
    :param z: (K, 2) what the blob measures of the track's position [px].
    :param R: (K, 2, 2) its covariance [px^2].
    :param likelihood: (K,) log of the density of z, by what was predicted.
    :param turned: (K,) probability that the track has maneuvered, if the blob is its own.
    :param nis: (K,) innovation squared, normalized by its covariance.
    :param predicted: (K,) share of the prediction in that covariance, 0..1; the rest is R.
    :param innovation: (K, 2) over the fourth root of the determinant of its covariance.
    """

    track: Indices
    blob: Indices
    z: Floats
    R: Floats
    likelihood: Floats
    turned: Floats
    nis: Floats
    predicted: Floats
    innovation: Floats

    def take(self, index: Indices) -> 'Pairs':
        """Some of the pairs, in the same order."""
        if len(index) == len(self.track):
            return self
        return Pairs(*(getattr(self, field.name)[index] for field in fields(self)))
