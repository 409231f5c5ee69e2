"""The measurement of contours: edges on lines across them."""

import numpy as np

from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.gating import gate
from colortrack_ros.contours.lines import find_edges
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Frame

SIDES_SHARE = 0.1
"""Weight of a measurement in the usual intensities beside an edge. Assumed: half and twice
the value change nothing on `silhouette` and `approach` (``benchmark/contours.py --constants
measurement.SIDES_SHARE``)."""

GATE_SIGMA = 0.5
"""Largest standard deviation of a node in the gate [px]: after a time unseen, any edge would agree
with the prediction, but edges still have to agree with each other. The mean squared error is 0.027
instead of 0.023 px^2 on `approach` with 0.25, 0.027 instead of 0.064 on `silhouette` with 1.0."""


def measure(
    frame: Frame,
    contours: Contours,
    spline: Spline,
    frames: float,
    least: float,
    config: ContourConfig,
) -> tuple[Bools, Floats]:
    """Update contours with the edges on their lines, and learn the intensities beside them.

    :param frames: time since the last frame [frames].
    :param least: share of lines that need an edge.
    :return: whether enough lines had one, and their share, (N,) each.
    """
    if not len(contours):
        return np.zeros(0, bool), np.zeros(0)
    usual, normals = contours.sides, spline.normals(contours.nodes)
    spread = contours.sigma_along(normals)
    sigma = np.hypot(config.sigma, spread)
    edges = find_edges(frame.image, contours.nodes, normals, sigma, usual, config)
    spread = np.hypot(np.minimum(spread, GATE_SIGMA), config.edge_variance**0.5)
    good = gate(edges.offset, edges.found, spread, normals, contours.nodes, config)
    share = good.mean(axis=1)
    measured = share >= max(least, 1e-9)
    good &= measured[:, None]
    contours.correct(edges.offset, good, normals, frames, config)
    before, now = usual[good], edges.sides[good]
    usual[good] = np.where(np.isnan(before), now, before + SIDES_SHARE * (now - before))
    return np.asarray(measured), np.asarray(share)
