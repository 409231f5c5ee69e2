"""What a stereo camera makes of true depths: errors that grow with the square, and holes."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

MATCHED_AT_ONCE = 8
"""Pixels on each side of what a stereo camera matches at once, whose errors are alike. Assumed: as
of usual block matching. With half and twice as many, things are located to 0.76 and 0.74 % of the
range, not 0.81, with another seed to 1.14 and 1.17, as with this (the run with noise and holes of
test_simulation)."""

EDGE_STEP = 0.1
"""A step of depth by this share between pixels beside each other is an edge, at which one of the
cameras sees what the other does not. Assumed; half and twice the value change nothing there."""


class StereoErrors:
    """Errors of depth pictures.

    :param noise: standard deviation at 1 m, which grows with the square of the depth [1/m].
    :param holes: share of the picture that is lost, besides the edges, 0..1.
    """

    def __init__(self, noise: float, holes: float, rng: np.random.Generator) -> None:
        self._noise, self._holes, self._rng = noise, holes, rng

    def of(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """What is measured of true depths, (H, W) [m]; NaN in holes."""
        if self._noise > 0:
            error = self._windows(depth.shape, self._rng.standard_normal)
            depth = depth + np.float32(self._noise) * depth * depth * error
        if self._holes > 0:
            lost = self._windows(depth.shape, self._rng.random) < self._holes
            depth = np.where(lost | _edges(depth), np.float32(np.nan), depth)
        return depth

    def _windows(self, shape: tuple[int, ...], draw: Any) -> NDArray[np.float32]:
        """Random numbers, (H, W), alike within each window."""
        height, width = shape
        size = -(-height // MATCHED_AT_ONCE) + 1, -(-width // MATCHED_AT_ONCE) + 1
        drawn = np.repeat(np.repeat(draw(size, np.float32), MATCHED_AT_ONCE, 0), MATCHED_AT_ONCE, 1)
        top, left = self._rng.integers(0, MATCHED_AT_ONCE, 2)
        return np.asarray(drawn[top : top + height, left : left + width])


def _edges(depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Which pixels, (H, W), are beside a step."""
    kernel = np.ones((3, 3), np.uint8)
    with np.errstate(invalid='ignore'):
        step = cv2.dilate(depth, kernel) - cv2.erode(depth, kernel)
        return np.asarray(step > EDGE_STEP * depth)
