"""What is published of the targets."""

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
"""Share of what a curve misses of an outline that does not cancel out from node to node. It sets
the covariance alone: half, once and twice the value make the normalized squared error, 2 when
right, 0.89, 0.62, 0.28 on `silhouette` and 1.24, 1.06, 0.72 on `approach`
(``benchmark/contours.py --constants publishing.CORRELATED_MISFIT``)."""


def published(
    tracks: TrackTable[Contours], spline: Spline, config: ContourConfig, now: int
) -> tuple[NDArray[np.void], Floats]:
    """Rows and outlines of all but confirmed tracks that probably do not exist any more."""
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
