"""Access to pixels of any encoding as RGB."""

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.encodings import bgr_at
from colortrack_ros.encodings import is_yuv
from colortrack_ros.encodings import size_of

Pixels = tuple[NDArray[np.intp], NDArray[np.intp]]
"""Rows and columns, (N,) each."""

RED_FIRST = ('rgb8', 'rgba8')
"""Encodings whose first channel is red; in the others it is blue."""


def rgb_of(pixels: NDArray[np.uint8], encoding: str) -> NDArray[np.uint8]:
    """RGB, (N, 3), of pixels, (N, channels) or (N,)."""
    if encoding == 'mono8':
        return np.repeat(pixels.reshape(-1, 1), 3, axis=1)
    return pixels[:, :3] if encoding in RED_FIRST else pixels[:, 2::-1]


def pixels_at(frame: Frame, position: NDArray[np.intp]) -> NDArray[np.uint8]:
    """(..., channels) single pixels; BGR for YUV pictures.

    :param position: v width + u.
    """
    height, width = size_of(frame)
    if not is_yuv(frame) and frame.image.flags.c_contiguous:
        return frame.image.reshape(height * width, -1).take(position, axis=0)
    pixel = np.divmod(position, width)
    if is_yuv(frame):
        return bgr_at(frame, *pixel)
    return frame.image[pixel].reshape(*position.shape, -1)


def rgb_at(frame: Frame, pixel: Pixels) -> NDArray[np.uint8]:
    """RGB, (N, 3), of single pixels.

    :param pixel: (N,) rows and columns.
    """
    if is_yuv(frame):
        return bgr_at(frame, *pixel)[:, ::-1]
    return rgb_of(frame.image[pixel], frame.encoding)


def split_rgb(picture: NDArray[np.uint8], encoding: str) -> list[NDArray]:
    """Red, green and blue channel of a picture, (H, W) each."""
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
