"""Which blob of a frame each thing of the last frame is in."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.parts import LEAST_VISIBLE

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Labels = NDArray[np.uint8]

IN_NONE = -1
"""In place of the number of a blob: the thing is in none."""

NEXT_TO_IT = 1.0
"""How far a thing may be from where it was, or is expected, when no other thing is in the blob and
the thing is in no other [side of a square of the blob's area]: its boxes then still overlap."""


def claim_blobs(
    expected: Floats, last: Floats, label: Labels, area: Indices, blobs: BlobTable
) -> tuple[Indices, bool]:
    """Claim the blob whose box holds the expected place; who gets none, one that is near.

    :param expected: (N, 2) where things are expected [px].
    :param last: (N, 2) where they were [px].
    :param label: (N,) of their pixels.
    :param area: (N,) of each when it was last alone [px].
    :return: (N,) a blob or IN_NONE; and whether all are in the boxes of one each.
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
    """The blob whose box holds the expected place: one for each, as far as there are as many."""
    away = expected[:, None] - (blobs.box[:, :2] - 0.5)
    inside = ((away >= 0) & (away <= blobs.box[:, 2:])).all(axis=2)
    inside &= label[:, None] == blobs.label
    thing, blob = inside.nonzero()
    claim = np.full(len(expected), IN_NONE)
    claim[thing] = blob
    if len(thing) == len(expected) == len(set(blob.tolist())) == len(set(thing.tolist())):
        return claim, True
    if not len(thing):
        return claim, False
    away = np.hypot(*(expected[thing] - blobs.mean[blob]).T)
    order = np.argsort(away, kind='stable')
    thing, blob = thing[order], blob[order]
    # Those that get no blob of their own are in the nearest, with others.
    claim[thing[::-1]] = blob[::-1]
    left = np.bincount(thing)[thing] * np.bincount(blob)[blob] > 1
    while left.any():
        first = left.argmax()
        claim[thing[first]] = blob[first]
        left &= (thing != thing[first]) & (blob != blob[first])
    return claim, False


def _of_nobody(places: Floats, label: Labels, claim: Indices, blobs: BlobTable) -> Indices:
    """(K,) the nearest blob that no thing claims, for things that start or stop at once.

    :param places: (2, K, 2) where each is expected and where it was [px].
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
    """(K,) the nearest blob that is larger than what it holds, for things that run into others.

    By as much as would have to be seen of them, see parts.seen_of().

    :param places: as of _of_nobody().
    :param excess: (M,) area of each blob beyond that of the things in it [px].
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
