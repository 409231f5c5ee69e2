"""The published rows and outlines of targets."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.filters import Floats
from colortrack_ros.contours.position import positions
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.track_table import TrackTable

CORRELATED_MISFIT = 0.35
"""Share of the misfit between curve and outline that does not average out over the nodes. It
affects only the covariance: with half, once, and twice the value the normalized squared error, 2 if
right, is 0.89, 0.62, 0.28 on `silhouette` and 1.24, 1.06, 0.72 on `approach`
(``benchmark/contours.py --constants publishing.CORRELATED_MISFIT``)."""


def published(
    tracks: TrackTable[Contours], spline: Spline, config: ContourConfig, now: int
) -> tuple[NDArray[np.void], Floats]:
    """Return rows and outlines of all but confirmed tracks that probably no longer exist."""
    fresh = tracks.freshness(now, config.max_time_since_update)
    score = np.clip(tracks.records['edge_share'], 0, 1) * fresh
    shown = (score >= config.min_score) | (tracks.records['state'] == TENTATIVE)
    tracks, score = tracks.take(shown), score[shown]
    contours = tracks.filters
    area, outlines = spline.area(contours.nodes), spline.outline(contours.nodes)
    misfit = (CORRELATED_MISFIT * tracks.records['misfit']) ** 2 * np.maximum(area, 0.0)
    rows = tracks.rows(now, *positions(contours, spline, config.rate, misfit))
    rows['area'], rows['score'] = area, score
    rows['box_w'], rows['box_h'] = np.ptp(outlines, axis=1).T
    return rows, outlines
