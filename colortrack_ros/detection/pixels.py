"""Pixels of any encoding as red, green and blue."""

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame

RED_FIRST = ('rgb8', 'rgba8')
"""Encodings whose first channel is red; in the others it is blue."""


def rgb_of(pixels: NDArray[np.uint8], encoding: str) -> NDArray[np.uint8]:
    """Red, green and blue, (N, 3), of pixels, (N, channels) or (N,)."""
    if encoding == 'mono8':
        return np.repeat(pixels.reshape(-1, 1), 3, axis=1)
    return pixels[:, :3] if encoding in RED_FIRST else pixels[:, 2::-1]


def split_rgb(picture: NDArray[np.uint8], encoding: str) -> list[NDArray]:
    """Red, green and blue of a picture, (H, W) each."""
    if encoding == 'mono8':
        return [picture.reshape(picture.shape[:2])] * 3
    order = (0, 1, 2) if encoding in RED_FIRST else (2, 1, 0)
    return [cv2.extractChannel(picture, channel) for channel in order]


def channels_of(frame: Frame) -> NDArray:
    """The picture as (H, W, channels), without alpha."""
    picture = frame.image
    if picture.ndim == 2:
        return picture[..., None]
    return cv2.cvtColor(picture, cv2.COLOR_BGRA2BGR) if picture.shape[2] == 4 else picture
