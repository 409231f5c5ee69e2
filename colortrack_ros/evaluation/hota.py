"""Higher order tracking accuracy (Luiten et al. 2021), by the definitions of TrackEval."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

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
        rows = [np.searchsorted(ids, f[0]) for f in self.frames]
        columns = [np.searchsorted(names, f[1]) for f in self.frames]
        potential = np.zeros((len(ids), len(names)))
        for i, j, (_, _, similarity) in zip(rows, columns, self.frames, strict=True):
            union = similarity.sum(axis=0) + similarity.sum(axis=1)[:, None] - similarity
            potential[np.ix_(i, j)] += similarity / np.maximum(union, EPSILON)
        aligned = potential / (objects[:, None] + tracks - potential)
        matches = np.zeros((len(SIMILARITIES), len(ids), len(names)))
        localized = np.zeros(len(SIMILARITIES))
        for i, j, (_, _, similarity) in zip(rows, columns, self.frames, strict=True):
            a, b = linear_sum_assignment(-aligned[np.ix_(i, j)] * similarity)
            found = similarity[a, b] >= SIMILARITIES[:, None] - EPSILON
            matches[:, i[a], j[b]] += found
            localized += (found * similarity[a, b]).sum(axis=1)
        hits = matches.sum(axis=(1, 2))
        deta = hits / (objects.sum() + tracks.sum() - hits)
        share = matches / (objects[:, None] + tracks - matches)
        assa = (matches * share).sum(axis=(1, 2)) / np.maximum(hits, 1)
        loca = np.where(hits > 0, localized / np.maximum(hits, 1), 1)
        return Hota(*(float(x.mean()) for x in (np.sqrt(deta * assa), deta, assa, loca)))


def _joined(parts: list[Indices]) -> Indices:
    return np.concatenate([*parts, np.zeros(0, int)]).astype(int)
