"""Pixels for all directions, those that the picture does not show included.

Inside of the picture they are those of the lens. Beyond, they go on outwards by one focal length a
radian, up to what is straight behind the camera: no direction is lost, and what comes back into the
picture does so at its border.
"""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.world.camera import CameraModel

Floats = NDArray[np.float64]

MOST_BEHIND = np.pi - 0.01
"""Largest angle off the optical axis of a pixel's direction [rad]. Straight behind the camera, all
pixels of a circle would share one direction, and rounding would decide to which of them it maps
back. 0.01 rad are 5 px at f = 500 px. Chosen."""


def directions_of(camera: CameraModel, pixels: Floats) -> Floats:
    """The directions at pixels, (N, 2), in the picture or not: (N, 3) unit vectors, optical."""
    flat = camera.flat(pixels)
    radius, side = _polar(flat)
    (beyond,) = (radius > camera.reach).nonzero()
    flat[beyond] = side[beyond] * camera.reach
    rays = camera.lens.undistort(flat)
    angle = _angles(rays[beyond]) + radius[beyond] - camera.reach
    angle = np.minimum(angle, MOST_BEHIND)[:, None]
    rays[beyond] = np.concatenate([side[beyond] * np.sin(angle), np.cos(angle)], axis=1)
    return rays


def pixels_of(camera: CameraModel, rays: Floats) -> Floats:
    """The pixels of directions, (N, 3) unit vectors: (N, 2), in the picture or not."""
    flat, _ = camera.lens.distort(rays)
    # of what the lens does not see nothing compares as near
    (beyond,) = (~(np.hypot(flat[:, 0], flat[:, 1]) <= camera.reach)).nonzero()
    _, side = _polar(rays[beyond, :2])
    at_edge = _angles(camera.lens.undistort(side * camera.reach))
    flat[beyond] = side * (camera.reach + _angles(rays[beyond]) - at_edge)[:, None]
    return np.asarray(flat @ camera.K[:2, :2].T + camera.K[:2, 2])


def _angles(rays: Floats) -> Floats:
    """Off the optical axis [rad]."""
    return np.arctan2(np.hypot(rays[:, 0], rays[:, 1]), rays[:, 2].copy())


def _polar(flat: Floats) -> tuple[Floats, Floats]:
    """The lengths of vectors, (N, 2), and their directions, of no length any."""
    length = np.hypot(flat[:, 0], flat[:, 1])
    side = flat / np.where(length > 0, length, 1.0)[:, None]
    side[length == 0] = [1.0, 0.0]
    return length, side
