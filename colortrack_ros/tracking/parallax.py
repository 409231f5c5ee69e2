"""Parallax: how near what stands is, by how a camera that drives moves it in the picture."""

import numpy as np

from colortrack_ros.data import Floats

STILL_SIGMAS = 3.0
"""Standard deviations within which what is left of a velocity is none."""

OFF_GROUND = 0.3
"""Standard deviation of the inverse distances of objects that are not where they would be if they
stood on the ground [1/m]. Assumed: they are some meters away, and as many are elsewhere as not."""

CLOSEST = 0.1
"""Least distance of an object from the camera [m]. Chosen: a hand's breadth."""


def off_nearness(nearness: Floats, velocity: Floats, cov: Floats, slope: Floats) -> Floats:
    """Return what inverse distances of objects are off by, (N,) [1/m]; 0 where nothing tells.

    An object that stands at another distance than assumed seems to move along the epipolar line, at
    a speed proportional to the error. Weighted least squares gives the error; the object stands if
    nothing significant is left of its velocity.

    :param nearness: (N,) assumed inverse distances [1/m].
    :param velocity: (N, 2) beside what the motion of the camera explains [px/s].
    :param cov: (N, 2, 2) of it.
    :param slope: (N, 2) derivative of the velocity that the camera's motion gives, by the inverse
        distance [px m/s].
    """
    W = np.linalg.inv(cov)
    weighted = (W @ slope[..., None])[..., 0]
    information = (weighted * slope).sum(axis=1)
    told = information > 0
    off = (weighted * velocity).sum(axis=1) / np.where(told, information, 1.0)
    rest = velocity - off[:, None] * slope
    d2 = (rest * (W @ rest[..., None])[..., 0]).sum(axis=1)
    share = OFF_GROUND**2 * information
    told &= (off**2 * information * share / (1 + share) > np.log1p(share)) & (d2 < STILL_SIGMAS**2)
    off *= share / (1 + share)
    now = nearness + off
    return np.where(told & (now >= 0) & (now < 1 / CLOSEST), off, 0.0)
