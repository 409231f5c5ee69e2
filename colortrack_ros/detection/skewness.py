"""Third moments of blobs, which distinguish cut objects from complete ones."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.covariance import outline_length
from colortrack_ros.detection.covariance import OUTLINE_VARIANCE
from colortrack_ros.detection.shape import PIXEL_MOMENT

Column = NDArray[np.float64]

LEARN_RATE = 0.2
"""Rate at which the usual skewness of a color and its spread adapt [1/s]. A second behind an
occluder changes them by less than a small occlusion causes, and half a disc, 1.2, becomes usual
after a few seconds. Like the constants of covariance.py, it is tested by `python
benchmark/detection_covariance.py`."""

SPREADS = 2
"""Number of mean deviations from the usual skewness up to which a value is usual: 95 % of a Laplace
distribution are within 3, 86 % within 2."""

USUAL_SHARE = 1 / 4
"""Share of a usual skewness that still counts: the labeled centers of real objects that are held
and turned (a box, cups, a ball in a hand) are 0.05 to 0.2 half axes from the centroid of their
color."""

CHANCES = 2
"""Number of root mean squares of what chance does up to which a skewness is taken for chance: 98 %
of complex normal numbers are within."""


class UsualSkewness:
    """Learns the usual three-fold skewness of the blobs of each color.

    A ball has none, but a cone and a hand do. Any excess is due to a cut. The first blobs of a
    color are assumed to be usual.

    :param labels: the largest label.
    """

    def __init__(self, labels: int) -> None:
        self._usual = np.full(labels + 1, np.nan)
        self._deviation = np.zeros(labels + 1)
        self._stamp = 0

    def beyond(self, blobs: BlobTable, whole: NDArray[np.bool_], stamp: int) -> Column:
        """Compute the excess skewness of the blobs of a frame, and learn from them.

        :param whole: (N,) which are completely inside the picture; the others are not learned from.
        :param stamp: of the frame [ns].
        :returns: (N,) the part of each skewness beyond the usual, and a share of the rest.
        """
        skewness, label = beyond_chance(three_fold_skewness(blobs), blobs), blobs.label
        step = LEARN_RATE * min(max(stamp - self._stamp, 0) / NANOSECONDS, 1)
        self._stamp = stamp
        count = np.bincount(label[whole], minlength=len(self._usual))
        total = np.bincount(label[whole], skewness[whole], len(self._usual))
        seen = count > 0
        now = total[seen] / count[seen]
        usual = self._usual[seen]
        usual = np.where(np.isnan(usual), now, usual)
        away = now - usual
        self._usual[seen] = usual + away.clip(-step, step)
        self._deviation[seen] += (np.abs(away) - self._deviation[seen]).clip(-step, step)
        limit = (self._usual + SPREADS * self._deviation)[label]
        beyond = np.maximum(skewness - np.where(np.isnan(limit), 0, limit), 0)
        return beyond + USUAL_SHARE * (skewness - beyond)


def beyond_chance(skewness: Column, blobs: BlobTable) -> Column:
    """What is left of the skewness of blobs without that of outline pixels in or out by chance.

    On the outline of a disc, |z|^3 of :func:`three_fold_skewness` is 8.

    :returns: (N,).
    """
    chance = (8 * CHANCES) ** 2 * OUTLINE_VARIANCE * outline_length(blobs) / blobs.area**2
    return np.asarray(np.sqrt(np.maximum(skewness**2 - chance, 0)))


def three_fold_skewness(blobs: BlobTable) -> Column:
    """How much a blob, made round by an affine map, resembles a triangle.

    This is the modulus of the mean of z^3, z = p + i q, over the map in which the second moments
    along p and q are 1: 0 for an ellipse, a rectangle and two equal discs, 1.2 for half a disc, 2.3
    for a triangle. It does not depend on size, direction or elongation.

    :returns: (N,).
    """
    uu, uv, vv = blobs.spread[:, 0, 0], blobs.spread[:, 0, 1], blobs.spread[:, 1, 1]
    uu, vv = uu + PIXEL_MOMENT, vv + PIXEL_MOMENT
    # z = a u + b v from the centroid, by Cholesky.
    b = 1j / np.sqrt(vv - uv**2 / uu)
    a = 1 / np.sqrt(uu) - b * uv / uu
    a, b, squared = np.array([a, b, a * a]).repeat(blobs.run_count, axis=1)
    u, v = blobs.mean.T.repeat(blobs.run_count, axis=1)
    row, left, right = blobs.runs.ends()
    z, length = a * ((left + right - 1) / 2 - u) + b * (row - v), blobs.runs.length
    # The second moment of a run about its middle is (length^2 - 1) / 12, the third is 0.
    sums = length * z * (z * z + squared * ((length * length - 1) / 4))
    return np.abs(np.add.reduceat(sums, blobs.first_run)) / blobs.area
