"""Errors of a stereo camera: noise that grows with the square of the depth, and holes."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

MATCHED_AT_ONCE = 8
"""Side of the blocks that a stereo camera matches [px]; the pixels of one share their error.
Assumed: usual for block matching. With half and twice as many, things are located to 0.76 and
0.74 % of the range instead of 0.81 %; with another seed, to 1.14 and 1.17 %, about as with
8 (the run with noise and holes of test_simulation)."""

EDGE_STEP = 0.1
"""A step of the depth between neighboring pixels by this share is an edge, where one camera sees
what the other does not. Assumed; half and twice the value change nothing in that run."""


class StereoErrors:
    """Adds errors to depth pictures.

    :param noise: standard deviation at 1 m; it grows with the square of the depth [1/m].
    :param holes: share of the picture that is lost in addition to the edges, 0..1.
    """

    def __init__(self, noise: float, holes: float, rng: np.random.Generator) -> None:
        self._noise, self._holes, self._rng = noise, holes, rng

    def of(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return what is measured of true depths, (H, W) [m]; NaN in holes."""
        if self._noise > 0:
            error = self._windows(depth.shape, self._rng.standard_normal)
            depth = depth + np.float32(self._noise) * depth * depth * error
        if self._holes > 0:
            lost = self._windows(depth.shape, self._rng.random) < self._holes
            depth = np.where(lost | _edges(depth), np.float32(np.nan), depth)
        return depth

    def _windows(self, shape: tuple[int, ...], draw: Any) -> NDArray[np.float32]:
        """Return random numbers, (H, W), equal within each block."""
        height, width = shape
        size = -(-height // MATCHED_AT_ONCE) + 1, -(-width // MATCHED_AT_ONCE) + 1
        drawn = np.repeat(np.repeat(draw(size, np.float32), MATCHED_AT_ONCE, 0), MATCHED_AT_ONCE, 1)
        top, left = self._rng.integers(0, MATCHED_AT_ONCE, 2)
        return np.asarray(drawn[top : top + height, left : left + width])


def _edges(depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return which pixels, (H, W), are next to a step."""
    kernel = np.ones((3, 3), np.uint8)
    with np.errstate(invalid='ignore'):
        step = cv2.dilate(depth, kernel) - cv2.erode(depth, kernel)
        return np.asarray(step > EDGE_STEP * depth)
