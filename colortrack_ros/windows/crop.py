"""Gray crops of a picture, and windows in them at subpixel positions."""

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.data import Indices

Gray = NDArray

TO_GRAY = {
    'bgr8': cv2.COLOR_BGR2GRAY,
    'rgb8': cv2.COLOR_RGB2GRAY,
    'bgra8': cv2.COLOR_BGRA2GRAY,
    'rgba8': cv2.COLOR_RGBA2GRAY,
}


class Crop:
    """A gray part of a picture.

    :param gray: (H, W) gray levels, float32.
    :param corner: u, v of its top left pixel [px].
    :param times: each gray level is the mean of this many pixels of the picture on each axis.
    """

    def __init__(self, gray: Gray, corner: Indices, times: int = 1) -> None:
        self.gray, self.corner, self.times = gray, corner, times

    @classmethod
    def of(cls, frame: Frame, low: Indices, high: Indices, times: int = 1) -> 'Crop':
        """Return the part of a frame from pixel low to pixel high, (u, v), both included.

        Incomplete means at the right and at the bottom are cut off.
        """
        part: NDArray = frame.image[low[1] : high[1] + 1, low[0] : high[0] + 1]
        if frame.encoding in TO_GRAY:
            part = cv2.cvtColor(part, TO_GRAY[frame.encoding])
        part = np.asarray(part, np.float32)
        times = min(times, *part.shape[:2])
        if times > 1:
            rows, columns = part.shape[0] // times, part.shape[1] // times
            part = part[: rows * times, : columns * times]
            part = cv2.resize(part, (columns, rows), interpolation=cv2.INTER_AREA)
        return cls(part, low, times)

    def window(self, center: Floats, shape: tuple[int, ...]) -> Gray:
        """Return the window, (height, width), around a subpixel center.

        Outside the crop, its border is repeated.

        :param center: (u, v) [px].
        :param shape: height and width [gray levels].
        """
        u, v = ((center - self.corner - (self.times - 1) / 2) / self.times).tolist()
        return np.asarray(cv2.getRectSubPix(self.gray, shape[::-1], (u, v)))


def cut_window(frame: Frame, center: Floats, shape: tuple[int, ...], times: int = 1) -> Gray:
    """Return the window, (height, width), of a frame around a center (u, v) [px]; see Crop."""
    size, half = np.array(frame.image.shape[1::-1]), times * (np.array(shape[::-1]) / 2 + 1)
    low = np.clip(np.floor(center - half).astype(int), 0, size - 1)
    high = np.clip(np.ceil(center + half).astype(int), low, size - 1)
    return Crop.of(frame, low, high, times).window(center, shape)
