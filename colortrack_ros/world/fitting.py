"""Detections and depths that are of another picture than that of the calibration."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Detections
from colortrack_ros.world.view import View


def fitting(
    detections: Detections,
    depth: NDArray[np.float32] | None,
    view: View,
    tell: Callable[[str], object],
) -> tuple[Detections, NDArray[np.float32] | None]:
    """Return the detections, none if one is outside the picture, and its depths, None if unaligned.

    :param depth: (H, W) [m], or None.
    :param tell: receives a line about what does not fit.
    """
    if trouble := outside(detections, view):
        tell(trouble)
        detections = replace(detections, rows=detections.rows[:0])
    if depth is not None and (trouble := misaligned(depth, view)):
        tell(trouble)
        depth = None
    return detections, depth


def outside(detections: Detections, view: View) -> str:
    """Report a detection outside the picture of the calibration."""
    pixels = np.array([detections.rows['u'], detections.rows['v']]).T
    inside = view.camera.contains(pixels)
    if np.count_nonzero(inside) == len(inside):
        return ''
    out = pixels[~inside]
    return (
        f'a detection at u {out[0, 0]:.0f}, v {out[0, 1]:.0f} is outside of the '
        f'{view.camera.width}x{view.camera.height} picture of CameraInfo: the calibration is of '
        'another picture'
    )


def misaligned(depth: NDArray[np.float32], view: View) -> str:
    """Report depths, (H, W), whose pixels are not those of the picture."""
    height, width = depth.shape
    if (width, height) == (view.camera.width, view.camera.height):
        return ''
    return (
        f'depth picture of {width}x{height} pixels: expected the {view.camera.width}x'
        f'{view.camera.height} of CameraInfo; depth_topic is not of pictures aligned with the color'
    )
