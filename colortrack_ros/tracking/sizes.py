"""Sizes: whether a blob has the size of an object, and how much that tells."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Constants marked "assumed" were set by hand; benchmark/ablation.py --constants sizes.NAME shows
# what IDF1 becomes with half and twice the value.

TOLERANCE = 2.0
TOLERANCE_SHARE = 0.05
"""A box is whole when its size differs by no more than this from the track's [px], [1]: a pixel on
each side, and assumed changes of the object by a twentieth."""

OTHER_SIZE = 0.02
"""Probability that a blob has another size than its object. Assumed: one in 50, as for colors."""


def total(extent: Floats) -> Floats:
    """(K, 2) sizes of extents, (K, 2, 2): from the low to the high side [px]."""
    return np.asarray(extent[:, 0] + extent[:, 1])


def slack(size: Floats) -> Floats:
    """How much the size of a whole blob may differ from the object's size [px]."""
    return TOLERANCE + TOLERANCE_SHARE * size


def difference(size: Floats, blob: Floats) -> Floats:
    """Size of the blob beyond the object's, 0 within the tolerance.

    :param size: (K, 2) of the object [px].
    :param blob: (K, 2) of the blob [px].
    :return: (K, 2) [px], negative for a blob that is cut.
    """
    excess = blob - size
    return np.where(np.abs(excess) > slack(size), excess, 0.0)


def log_fit(size: Floats, blob: Floats, alike: float) -> Floats:
    """Log-likelihood ratio of blobs' sizes: of these objects, against of any other.

    An object's own blob differs by a slack, one in 50 by anything. Others are alike, or up to twice
    as large.

    :param size: (K, 2) of the object [px].
    :param blob: (K, 2) of the blob [px].
    :param alike: share of the others that have the size of an object.
    :return: (K,).
    """
    e = (blob - size) / slack(size)
    e *= e
    d2 = e[:, 0] + e[:, 1]
    return np.asarray(np.log(OTHER_SIZE + np.exp(most_fitting(size, alike) - d2 / 2)))


def most_fitting(size: Floats, alike: float) -> Floats:
    """Log-likelihood ratio, at least 0, of a blob of just that size, (K, 2); see log_fit()."""
    share = slack(size) / np.maximum(size, 1.0)
    broad = np.pi / 2 * (share[:, 0] * share[:, 1])
    return np.asarray(np.log(np.maximum((1 - OTHER_SIZE) / (alike + broad), 1.0)))


def count_alike(size: Floats, blob: Floats) -> int:
    """Number of blobs, (K, 2) [px], that have the size of any of the objects, (N, 2) [px]."""
    same = np.abs(blob[:, None] - size) <= slack(size)
    return int(np.count_nonzero((same[..., 0] & same[..., 1]).any(axis=1)))
