"""Position and velocity of targets, with covariance, from their contours."""

import numpy as np

from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.filters import motion_matrix
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import Floats


def positions(
    contours: Contours, spline: Spline, rate: float, misfit: Floats
) -> tuple[Floats, Floats]:
    """Return the centroids of the splines' areas, and their velocities.

    The covariance of nodes and motion is propagated by the derivatives, and so is the misfit
    between curve and outline.

    :param rate: frames of the filters per second.
    :param misfit: (N,) additional variance of each node, unknown to the filters [px^2].
    :return: (N, 4) u, v [px], du, dv [px/s], and its covariance (N, 4, 4).
    """
    center, derivative = spline.centroid(contours.nodes)
    n = contours.nodes.shape[1]
    J = derivative.reshape(-1, 2, 2 * n)
    V = rate * J @ motion_matrix(contours.nodes)
    carry = np.zeros((len(contours), 4, contours.cov.shape[1]))
    carry[:, :2, : 2 * n], carry[:, 2:, 2 * n :] = J, V
    mean = np.concatenate([center, (V @ contours.motion[..., None])[..., 0]], axis=1)
    covariance = carry @ contours.cov @ carry.swapaxes(1, 2)
    covariance[:, :2, :2] += misfit[:, None, None] * (J @ J.swapaxes(1, 2))
    return mean, covariance
