"""Ellipses of two-dimensional normal distributions."""

import numpy as np
from numpy.typing import NDArray

ELLIPSE_95 = -2 * np.log(0.05)
"""Squared Mahalanobis distance of the ellipse that holds 95 % of the distribution: chi-squared with
two degrees of freedom is exponential with mean 2."""


def ellipses(
    covariance: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Angle [rad] of the major axis, and the standard deviations along both axes, (N,).

    :param covariance: (N, 2, 2); a variance below zero counts as zero.
    """
    # Not by LAPACK, whose last bits depend on memory alignment; so do those of NumPy 1's arctan2
    # (and exp, log, power) on columns of a table, hence the copies.
    a, b, c = covariance[:, 0, 0], covariance[:, 0, 1].copy(), covariance[:, 1, 1]
    mean, half = (a + c) / 2, (a - c) / 2
    spread = np.sqrt(half * half + b * b)
    major, minor = (np.sqrt(np.maximum(v, 0.0)) for v in (mean + spread, mean - spread))
    return np.arctan2(b, half) / 2, major, minor


def outlines(
    centers: NDArray[np.float64], covariance: NDArray[np.float64], points: int
) -> NDArray[np.float64]:
    """Closed polylines, the ellipses that hold 95 % of each distribution, (N, points, 2).

    :param centers: (N, 2); covariance: (N, 2, 2).
    """
    turn = np.linspace(0, 2 * np.pi, points)
    angle, major, minor = ellipses(covariance)
    axes = np.stack([np.cos(angle), np.sin(angle), -np.sin(angle), np.cos(angle)], axis=1)
    lengths = np.sqrt(ELLIPSE_95) * np.stack([major, minor], axis=1)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return centers[:, None] + (circle * lengths[:, None]) @ axes.reshape(-1, 2, 2)
