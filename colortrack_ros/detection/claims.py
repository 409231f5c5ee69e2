"""Association of the objects of the last frame with the blobs of this one."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.parts import LEAST_VISIBLE

Labels = NDArray[np.uint8]

IN_NONE = -1
"""Replaces a blob's number: the object is in no blob."""

NEXT_TO_IT = 1.0
"""Largest distance of a blob from an object's last or expected place, if both are unclaimed [side
of a square of the blob's area]: the boxes still overlap."""

MERGED = 1.25
"""Least area of a blob with several objects over that of the largest of them. Chosen: what is
covered by another of its color adds less, and a lesser error of the usual area does no harm."""


def hold_several(places: Floats, label: Labels, area: Indices, blobs: BlobTable) -> Bools:
    """(M,) whether objects of the last frame are merged in a blob.

    :param places: (N, 2) of the objects [px].
    :param label: (N,) of their pixels.
    :param area: (N,) of each when it was last alone [px].
    """
    if len(label) < 2 or not len(blobs.area):
        return np.zeros(len(blobs.area), bool)
    inside = _are_inside(places, label, blobs)
    largest = (inside * area[:, None]).max(axis=0)
    return np.asarray((inside.sum(axis=0) > 1) & (blobs.area > MERGED * largest))


def claim_blobs(
    expected: Floats, last: Floats, label: Labels, area: Indices, blobs: BlobTable
) -> tuple[Indices, bool]:
    """Claim the blob whose box contains the expected place; objects without one get a blob nearby.

    :param expected: (N, 2) expected places of the objects [px].
    :param last: (N, 2) their last places [px].
    :param label: (N,) of their pixels.
    :param area: (N,) of each when it was last alone [px].
    :return: (N,) a blob or IN_NONE; and whether each is alone in the box of one blob.
    """
    claim, single = _by_place(expected, label, blobs)
    lost = np.flatnonzero(claim == IN_NONE)
    if len(lost):
        places = np.stack([expected[lost], last[lost]])
        claim[lost] = _of_nobody(places, label[lost], claim, blobs)
        left = claim[lost] == IN_NONE
        lost, places = lost[left], places[:, left]
    if len(lost):
        held = claim >= 0
        within = np.bincount(claim[held], area[held], len(blobs.area))
        excess = np.asarray(blobs.area - within, float)
        claim[lost] = _grown(places, label[lost], area[lost], excess, blobs)
    return claim, single


def _by_place(expected: Floats, label: Labels, blobs: BlobTable) -> tuple[Indices, bool]:
    """Claim the blob whose box contains the expected place, with one object per blob if
    possible.
    """
    thing, blob = _are_inside(expected, label, blobs).nonzero()
    claim = np.full(len(expected), IN_NONE)
    claim[thing] = blob
    if len(thing) == len(expected) == len(set(blob.tolist())) == len(set(thing.tolist())):
        return claim, True
    if not len(thing):
        return claim, False
    away = np.hypot(*(expected[thing] - blobs.mean[blob]).T)
    order = np.argsort(away, kind='stable')
    thing, blob = thing[order], blob[order]
    # Objects that get no blob of their own share the nearest one.
    claim[thing[::-1]] = blob[::-1]
    left = np.bincount(thing)[thing] * np.bincount(blob)[blob] > 1
    while left.any():
        first = left.argmax()
        claim[thing[first]] = blob[first]
        left &= (thing != thing[first]) & (blob != blob[first])
    return claim, False


def _are_inside(places: Floats, label: Labels, blobs: BlobTable) -> Bools:
    """(N, M) whether each place is in the box of each blob, and of its label."""
    away = places[:, None] - (blobs.box[:, :2] - 0.5)
    inside = ((away >= 0) & (away <= blobs.box[:, 2:])).all(axis=2)
    return np.asarray(inside & (label[:, None] == blobs.label))


def _of_nobody(places: Floats, label: Labels, claim: Indices, blobs: BlobTable) -> Indices:
    """(K,) the nearest unclaimed blob, for objects that start or stop abruptly.

    :param places: (2, K, 2) expected and last place of each [px].
    """
    found = np.full(len(label), IN_NONE)
    blob = np.setdiff1d(np.arange(len(blobs.area)), claim)
    away = np.hypot(*(places[:, :, None] - blobs.mean[blob]).transpose(3, 0, 1, 2)).min(axis=0)
    away /= np.sqrt(blobs.area[blob])
    away[label[:, None] != blobs.label[blob]] = np.inf
    while away.size and away.min() <= NEXT_TO_IT:
        i, j = np.unravel_index(away.argmin(), away.shape)
        found[i] = blob[j]
        away[i], away[:, j] = np.inf, np.inf
    return found


def _grown(
    places: Floats, label: Labels, area: Indices, excess: Floats, blobs: BlobTable
) -> Indices:
    """(K,) the nearest blob larger than the objects in it, for objects that run into others.

    The excess must be as large as the part that has to be visible, see parts.seen_of().

    :param places: as in _of_nobody().
    :param excess: (M,) area of each blob beyond that of the objects in it [px].
    """
    if not len(excess):
        return np.full(len(label), IN_NONE)
    middle = blobs.box[:, :2] - 0.5 + blobs.box[:, 2:] / 2
    gap = np.abs(places[:, :, None] - middle) - blobs.box[:, 2:] / 2
    gap = gap.max(axis=3).min(axis=0) - np.sqrt(area)[:, None] / 2
    holds = excess > LEAST_VISIBLE * area[:, None] + np.sqrt(blobs.area)
    gap[~holds | (label[:, None] != blobs.label)] = np.inf
    nearest = gap.argmin(axis=1)
    return np.where(gap.min(axis=1) <= 0, nearest, IN_NONE)
