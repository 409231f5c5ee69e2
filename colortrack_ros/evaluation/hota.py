"""Higher order tracking accuracy (Luiten et al. 2021), by the definitions of TrackEval."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices

SIMILARITIES = np.arange(0.05, 0.99, 0.05)
"""Similarity thresholds of a match; all measures are means over them (ibid., 5)."""

EPSILON = np.finfo(float).eps
"""Tolerance for a similarity that equals a threshold up to rounding."""


class Hota(NamedTuple):
    """HOTA and its detection, association, and localization accuracies; means over SIMILARITIES."""

    hota: float
    deta: float
    assa: float
    loca: float


class HotaTally:
    """Collects frames and computes the measures.

    :ivar frames: objects (N,), tracks (M,) and similarities (N, M), 0..1, of each frame.
    """

    def __init__(self) -> None:
        self.frames: list[tuple[Indices, Indices, Floats]] = []

    def add(self, ids: Indices, names: Indices, similarity: Floats) -> None:
        """Take one frame."""
        self.frames.append((ids, names, similarity))

    def score(self) -> Hota:
        """Compute the measures.

        The matches of a frame maximize the similarity of whole tracks, (7) there.
        """
        ids, objects = np.unique(_joined([f[0] for f in self.frames]), return_counts=True)
        names, tracks = np.unique(_joined([f[1] for f in self.frames]), return_counts=True)
        if not len(ids) or not len(names):
            return Hota(0.0, 0.0, 0.0, 0.0)
        pairs, shares = [], []
        for one, other, similarity in self.frames:
            i, j = np.nonzero(similarity)
            union = similarity.sum(axis=0) + similarity.sum(axis=1)[:, None] - similarity
            pairs.append(
                np.searchsorted(ids, one)[i] * len(names) + np.searchsorted(names, other)[j]
            )
            shares.append((similarity / np.maximum(union, EPSILON))[i, j])
        # Only pairs that are ever near each other: a table of 1,500 objects and 6,000 tracks for
        # each threshold would take 4 GB.
        pair, which = np.unique(_joined(pairs), return_inverse=True)
        together = objects[pair // len(names)] + tracks[pair % len(names)]
        potential = np.bincount(which, np.concatenate(shares), len(pair))
        aligned = potential / (together - potential)
        matched, found = self._matches(np.split(aligned[which], np.cumsum([*map(len, pairs)])[:-1]))
        matches = np.stack([np.bincount(which, level, len(pair)) for level in found])
        hits = matches.sum(axis=1)
        deta = hits / (objects.sum() + tracks.sum() - hits)
        assa = (matches * (matches / (together - matches))).sum(axis=1) / np.maximum(hits, 1)
        loca = np.where(hits > 0, (found * matched).sum(axis=1) / np.maximum(hits, 1), 1)
        return Hota(*(float(x.mean()) for x in (np.sqrt(deta * assa), deta, assa, loca)))

    def _matches(self, aligned: list[Floats]) -> tuple[Floats, Bools]:
        """The similarity of each pair that is matched, and at which SIMILARITIES it is.

        :param aligned: for each frame, how well the tracks of its (K,) pairs agree as a whole.
        :return: for the K pairs of all frames, 0 and False for those that are not matched.
        """
        similarities = []
        for (_, _, similarity), weight in zip(self.frames, aligned, strict=True):
            i, j = np.nonzero(similarity)
            gain = np.zeros(similarity.shape)
            gain[i, j] = weight * similarity[i, j]
            chosen = np.zeros(similarity.shape, bool)
            chosen[linear_sum_assignment(-gain)] = True
            similarities.append(similarity[i, j] * chosen[i, j])
        matched = np.concatenate(similarities)
        return matched, matched >= SIMILARITIES[:, None] - EPSILON


def _joined(parts: list[Indices]) -> Indices:
    return np.concatenate([*parts, np.zeros(0, int)]).astype(int)
