"""Objects that stay on the ground, after each update, at the height that they have there.

The height z of a center is its height on the ground plus the error of that, HEIGHT. An update in
inverse depth w at fixed HEIGHT keeps dz = dHEIGHT only as far as w stays: if w becomes w', it
leaves dz = (w / w') dHEIGHT. The next picture, which measures z - HEIGHT as 0, would take that for
information about HEIGHT, and the same holds for the height of the camera. From a camera 0.15 m
high, HEIGHT of balls of 0.2 m was soon 4 standard deviations off. So the relation is restored by
moving the state, to first order, along the line on which it is seen at the same pixel.
"""

import numpy as np

from colortrack_ros.world.measurement import Measured
from colortrack_ros.world.measurement import PLANE
from colortrack_ros.world.measurement import PLANE_SIGMA
from colortrack_ros.world.measurement import two_ranges
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import HEIGHT
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.state import Motions
from colortrack_ros.world.state import POSITION
from colortrack_ros.world.view import LOWEST


def keep_on_ground(
    objects: Motions, measured: Measured, optical: Pose, kinds: Kinds, ground: float
) -> None:
    """Move states to the plane of their centers so that they are seen where they were, in place.

    States nearly as high as the camera stay: there the ground says nothing of the range.

    :param measured: N, in the last update; states without PLANE stay.
    :param optical: pose of the optical frame.
    :param ground: its height in the fixed frame [m].
    """
    whole, cov, axis = objects.whole, objects.cov, optical.R[:, 2]
    ray = objects.mean[..., POSITION] - optical.t
    deep = (ray @ axis)[..., None]
    # a sphere's blob has its center at (X, Y, Z - rho^2 / Z), so the sphere moves off its own ray
    flat = np.minimum(np.square(kinds.diameter[:, None, None] / 2 / deep), 1 / 2)
    ray += 2 * flat / (1 - flat) * (ray - deep * axis)
    low = measured.used[:, None, PLANE] & (np.abs(ray[..., 2]) > LOWEST)
    ray *= (low / np.where(low, ray[..., 2], 1.0))[..., None]
    off = whole[..., 2, :] - whole[..., HEIGHT, :]
    off[..., -1] -= ground + kinds.height[:, None]
    whole[..., POSITION, :] -= ray[..., None] * off[..., None, :]
    off = cov[..., 2] - cov[..., HEIGHT]
    cov[..., POSITION] -= off[..., None] * ray[..., None, :]
    # if the range is measured otherwise, PLANE is still exact: the noise would hide that range
    lone = ~two_ranges(measured)
    ray *= PLANE_SIGMA * lone[:, None, None]
    cov[..., POSITION, POSITION] += ray[..., None] * ray[..., None, :]
