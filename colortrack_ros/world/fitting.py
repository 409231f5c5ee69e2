"""Detections and depths that are of another picture than that of the calibration, or in no unit."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Detections
from colortrack_ros.world.view import View

SAMPLED = 16
"""Of the pixels of a depth picture along each axis, one in so many tells its unit. Chosen."""

SHALLOWEST, DEEPEST = 0.03, 200.0
"""Depths [m] that all of a picture in another unit is beyond: rooms in m are taken for 1 to 20 mm,
and, in mm, for 200 m or more from 0.2 m on. Depth cameras measure from 0.07 m on."""

NEAR_AND_FAR = 0.05, 0.95
"""Quantiles that stand for all of a picture: simulators have 65504 m where there is only sky."""


def fitting(
    detections: Detections,
    depth: NDArray[np.float32] | None,
    view: View,
    tell: Callable[[str], object],
) -> tuple[Detections, NDArray[np.float32] | None]:
    """Return the detections, none if one is outside the picture, and its depths, None if unusable.

    :param depth: (H, W) [m], or None.
    :param tell: receives a line about what does not fit.
    """
    if trouble := outside(detections, view):
        tell(trouble)
        detections = replace(detections, rows=detections.rows[:0])
    if depth is not None and (trouble := misaligned(depth, view) or off_scale(depth)):
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


def off_scale(depth: NDArray[np.float32]) -> str:
    """Report depths, (H, W), that are all holes, or that cannot be in m."""
    some = depth[::SAMPLED, ::SAMPLED]
    some = some[(some > 0) & (some < np.inf)]
    if not len(some) and not ((depth > 0) & (depth < np.inf)).any():
        return (
            'depth picture of nothing but holes: all is nearer or farther than its camera '
            'measures, or its projector is off'
        )
    near, far = np.quantile(some, NEAR_AND_FAR) if len(some) else (SHALLOWEST, DEEPEST)
    if near <= DEEPEST and far >= SHALLOWEST:
        return ''
    return f'depth picture of {np.median(some):g} m on average: expected mm in 16UC1, m in 32FC1'
