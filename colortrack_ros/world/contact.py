"""Objects that stay on the ground, after each update, at the height that they have there.

The height z of a center is its height on the ground plus the error of that, HEIGHT. An update in
inverse depth w at fixed HEIGHT keeps dz = dHEIGHT only as far as w stays: if w becomes w', it
leaves dz = (w / w') dHEIGHT. The next picture, which measures z - HEIGHT as 0, would take that for
information about HEIGHT, and the same holds for the height of the camera. From a camera 0.15 m
high, HEIGHT of balls of 0.2 m was soon 4 standard deviations off. So the relation is restored by
moving the state, to first order, along its ray, which changes no pixel.
"""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import PLANE_SIGMA
from colortrack_ros.world.measurement import two_ranges
from colortrack_ros.world.state import HEIGHT
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.view import LOWEST


def keep_on_ground(objects: Motions, measured: Measured, eye: Floats, plane: Floats) -> None:
    """Move states along their rays to the plane of their centers, in place.

    States nearly as high as the camera stay: there the ground says nothing of the range.

    :param measured: N, in the last update; states without PLANE stay.
    :param eye: (3,) position of the camera [m].
    :param plane: (N,) height of the center when on the ground, in the fixed frame [m].
    """
    whole, cov = objects.whole, objects.cov
    ray = objects.mean[..., POSITION] - eye
    low = measured.used[:, None, PLANE] & (np.abs(ray[..., 2]) > LOWEST)
    ray *= (low / np.where(low, ray[..., 2], 1.0))[..., None]
    off = whole[..., 2, :] - whole[..., HEIGHT, :]
    off[..., -1] -= plane[:, None]
    whole[..., POSITION, :] -= ray[..., None] * off[..., None, :]
    off = cov[..., 2] - cov[..., HEIGHT]
    cov[..., POSITION] -= off[..., None] * ray[..., None, :]
    # if the range is measured otherwise, PLANE is still exact: the noise would hide that range
    lone = ~two_ranges(measured)
    ray *= PLANE_SIGMA * lone[:, None, None]
    cov[..., POSITION, POSITION] += ray[..., None] * ray[..., None, :]
