"""Mapping between pixels and directions that includes directions outside the picture.

Inside the picture it is that of the lens. Outside, pixels continue outward by one focal length per
radian until straight behind the camera, so every direction has a pixel, and objects return to the
picture across its border.
"""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.world.camera import CameraModel

MOST_BEHIND = np.pi - 0.01
"""Largest angle between a pixel's direction and the optical axis [rad]. Straight behind the camera,
all pixels of a circle would share one direction, and rounding would decide which of them it maps
back to. 0.01 rad are 5 px at f = 500 px. Chosen."""


def directions_of(camera: CameraModel, pixels: Floats) -> Floats:
    """Return directions, (N, 3) optical unit vectors, of pixels, (N, 2), in the picture or not."""
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
    """Return the pixels, (N, 2), in the picture or not, of directions, (N, 3) unit vectors."""
    flat, _ = camera.lens.distort(rays)
    # negated, so that directions outside the lens, NaN, count as beyond
    (beyond,) = (~(np.hypot(flat[:, 0], flat[:, 1]) <= camera.reach)).nonzero()
    _, side = _polar(rays[beyond, :2])
    at_edge = _angles(camera.lens.undistort(side * camera.reach))
    flat[beyond] = side * (camera.reach + _angles(rays[beyond]) - at_edge)[:, None]
    return np.asarray(flat @ camera.K[:2, :2].T + camera.K[:2, 2])


def _angles(rays: Floats) -> Floats:
    """Return angles off the optical axis [rad]."""
    return np.arctan2(np.hypot(rays[:, 0], rays[:, 1]), rays[:, 2].copy())


def _polar(flat: Floats) -> tuple[Floats, Floats]:
    """Return lengths and directions of vectors, (N, 2); zero vectors get an arbitrary direction."""
    length = np.hypot(flat[:, 0], flat[:, 1])
    side = flat / np.where(length > 0, length, 1.0)[:, None]
    side[length == 0] = [1.0, 0.0]
    return length, side
