"""Segmentation of what moves by differencing three pictures."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.areas import Mask
from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS


class Differencing:
    """Finds what differs from both of two earlier pictures."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget earlier pictures."""
        self._earlier: list[Frame] = []

    def mask(self, frame: Frame, config: ContourConfig) -> Mask:
        """Return what differs from the pictures start_interval and twice that before."""
        picture, size = frame.image, config.opening_size
        earlier = [f for f in self._earlier if f.stamp < frame.stamp]
        earlier = [f for f in earlier if f.image.shape == picture.shape]
        interval = round(config.start_interval * NANOSECONDS)
        once, twice = frame.stamp - interval, frame.stamp - 2 * interval
        before = [f for f in earlier if f.stamp <= once]
        long_before = [f for f in earlier if f.stamp <= twice]
        self._earlier = [*long_before[-1:], *(f for f in earlier if f.stamp > twice), frame]
        if not long_before or not picture.size:
            return np.zeros(picture.shape[:2], np.uint8)
        least: NDArray[Any] = np.full(picture.shape[:2], 255, np.uint8)
        for one in (before[-1], long_before[-1]):
            apart = cv2.absdiff(picture, one.image).reshape(*picture.shape[:2], -1)
            mean = np.full((1, apart.shape[2]), 1 / apart.shape[2])
            least = cv2.min(least, cv2.transform(apart, mean))
        if config.blur_sigma > 0:
            least = cv2.GaussianBlur(least, (0, 0), config.blur_sigma)
        _, mask = cv2.threshold(least, config.difference_threshold, 255, cv2.THRESH_BINARY)
        square = np.ones((size, size), np.uint8)
        return np.asarray(cv2.morphologyEx(mask, cv2.MORPH_OPEN, square), np.uint8)
