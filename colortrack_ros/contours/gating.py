"""Gating of edges: which belong to a target, and which to something else."""

import numpy as np

from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.filters import motion_matrix
from colortrack_ros.contours.filters import MOTION_SIZE
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats

FIT_ROUNDS = 4
"""Iterations of the reweighted fit. With 2 and 8 the errors of `silhouette` and
`approach` are the same to 0.001 px^2 (``benchmark/contours.py --constants gating.FIT_ROUNDS``)."""

RIDGE = 1e-3
"""Regularization of the fit, added to the diagonal. Assumed: a line contributes about 1, so it
matters only where the edges do not determine the motion."""


def gate(
    offset: Floats, found: Bools, spread: Floats, normals: Floats, nodes: Floats,
    config: ContourConfig,
) -> Bools:  # fmt: skip
    """Return which edges agree with the prediction, or with a common motion of the whole contour.

    Whatever covers a part of a target has edges as well, which would compress its contour.
    Therefore only edges close to the prediction count, or, if these are more, edges close to a
    motion fitted to all of them: that with the least sum of absolute residuals, by iteratively
    reweighted least squares.

    :param offset: (N, n) of the edges from the prediction [px].
    :param found: (N, n) whether a line has an edge.
    :param spread: (N, n) standard deviation of the offsets [px].
    :return: (N, n), a subset of found.
    """
    if config.outlier == 0:
        return found
    limit = config.outlier * spread
    good = found & (np.abs(offset) <= limit)
    rest = np.flatnonzero((good != found).any(axis=1))
    if not len(rest):
        return good
    offset, found, limit = offset[rest], found[rest], limit[rest]
    H = _seen_motion(nodes[rest], normals[rest], rotation=config.rotation)
    residual = np.zeros_like(offset)
    for _ in range(FIT_ROUNDS):
        weighted = H * (found / np.maximum(residual, limit))[..., None]
        square = weighted.swapaxes(1, 2) @ H + RIDGE * np.eye(H.shape[2])
        fit = np.linalg.solve(square, weighted.swapaxes(1, 2) @ offset[..., None])
        residual = np.abs(offset - (H @ fit)[..., 0])
    # a fitted motion has to do better than the predicted one
    better = (found & (residual <= limit / 2)).sum(axis=1) > good[rest].sum(axis=1)
    good[rest[better]] = (found & (residual <= limit))[better]
    return good


def _seen_motion(nodes: Floats, normals: Floats, *, rotation: bool) -> Floats:
    """Return the design matrix of a motion along the lines, (N, n, 3 or 4), all in pixels."""
    H = motion_matrix(nodes).reshape(*nodes.shape, MOTION_SIZE)[
        ..., : MOTION_SIZE if rotation else MOTION_SIZE - 1
    ]
    H = (H * normals[..., None]).sum(axis=2)
    H[..., 2:] /= np.maximum(np.abs(H[..., 2:]).mean(axis=(1, 2), keepdims=True), 1.0)
    return H
