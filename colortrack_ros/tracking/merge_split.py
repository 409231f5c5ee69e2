"""Blobs that break and blobs that merge: which belong to which tracks, beyond one to one."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import TENTATIVE
from colortrack_ros.tracking.blobs import difference
from colortrack_ros.tracking.blobs import slack
from colortrack_ros.tracking.gating import candidates
from colortrack_ros.tracking.measurements import Blobs

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


def pieces(
    records: NDArray[np.void], blobs: Blobs, taken: Indices, free: Indices
) -> tuple[Indices, Indices]:
    """Find free blobs that, put together with a known object's blob, fit into its size.

    :param records: (N,) of dtype RECORD.
    :param blobs: of the frame.
    :param taken: (N,) the blob of each track, -1: none.
    :param free: indices of the blobs that no track has taken.
    :return: (K,) pieces, each once, and (K,) blobs that they belong to.
    """
    known = np.flatnonzero(
        (taken >= 0) & (records['state'] != TENTATIVE) & records['extent'].all(axis=(1, 2))
    )
    size, box = records['extent'][known].sum(axis=1), blobs.box[taken[known]]
    room = 1.05 * (size + slack(size))
    half = room - (box[:, 1] - box[:, 0]) / 2
    track, piece = candidates(box.mean(axis=1), half, blobs.box[free].mean(axis=1))
    whole, piece = taken[known[track]], free[piece]
    low = np.minimum(blobs.box[whole, 0], blobs.box[piece, 0])
    high = np.maximum(blobs.box[whole, 1], blobs.box[piece, 1])
    fits = (high - low <= room[track]).all(axis=1)
    color = blobs.rows['color']
    whole, piece = _once(whole[fits], piece[fits], color[whole[fits]], color)
    return piece, whole


def guests(
    records: NDArray[np.void], center: Floats, blobs: Blobs, taken: NDArray[np.intp]
) -> tuple[Indices, Indices]:
    """Find known objects without a blob that lie inside one too wide for the track that has it.

    :param records: (N,) of dtype RECORD.
    :param center: (N, 2) predicted centers [px].
    :param blobs: of the frame.
    :param taken: (N,) the blob of each track, -1: none.
    :return: (K,) tracks, each once, and (K,) blobs that they share.
    """
    host = np.flatnonzero(taken >= 0)
    excess = difference(records['extent'][host].sum(axis=1), blobs.size[taken[host]])
    wide = taken[host[(excess > 0).any(axis=1)]]
    lost = np.flatnonzero((taken < 0) & (records['state'] != TENTATIVE))
    blob, track = candidates(blobs.box[wide].mean(axis=1), blobs.size[wide] / 2, center[lost])
    blob, track = _once(wide[blob], lost[track], blobs.rows['color'][wide[blob]], records['color'])
    return track, blob


def _once(
    one: Indices, other: Indices, color: NDArray[np.uint32], colors: NDArray[np.uint32]
) -> tuple[Indices, Indices]:
    """Leave out pairs of unlike color, and keep the first pair of each other."""
    same = color == colors[other]
    other, first = np.unique(other[same], return_index=True)
    return one[same][first], other
