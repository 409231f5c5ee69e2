"""Objects by their color: Pegoretti 2021, 3.1.1."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.detection.background_model import BackgroundModel
from colortrack_ros.detection.blobs import Blobs
from colortrack_ros.detection.blobs import connect
from colortrack_ros.detection.color_table import ColorTable
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.pixels import channels_of
from colortrack_ros.detection.pixels import rgb_of

if TYPE_CHECKING:
    from colortrack_ros.detection.config import DetectorConfig


class Color:
    """Color distance (2.1) and threshold (2.2), and what makes them good for real rooms.

    With moving_only a pixel counts only where it differs from the learned background: things of
    the reference color that stand still are not found, and what passes in front of them is.
    """

    connect = staticmethod(connect)

    def __init__(self, config: 'DetectorConfig', background: BackgroundModel) -> None:
        self.labels = len(config.colors)
        self._config, self._background = config, background
        self._table = ColorTable(config.colors, config.threads)

    def label(self, frame: Frame) -> LabelImage:
        """The reference color that each pixel is within tolerance of."""
        image = self._table.label(frame.image, frame.encoding)
        if self._config.moving_only:
            self._drop_background(frame, image)
        return image

    def _drop_background(self, frame: Frame, image: LabelImage) -> None:
        """Set pixels to 0 that are like the background, all of them before there is one."""
        picture = channels_of(frame)
        if not self._background.knows(picture):
            image.padded[...] = 0
            return
        self._background.relight(picture)
        position = image.positions()
        v, u = np.divmod(position, image.stride)
        difference = self._background.difference_at(picture, v * image.width + u)
        still = difference <= self._config.difference_threshold
        image.padded.reshape(-1)[position[still]] = 0

    def closeness(
        self, frame: Frame, pixel: tuple[NDArray[np.intp], NDArray[np.intp]], label: NDArray
    ) -> NDArray[np.float64]:
        """1 - D / tolerance."""
        return self._table.closeness(rgb_of(frame.image[pixel], frame.encoding), label)

    def learn(self, frame: Frame, blobs: Blobs) -> None:
        """With moving_only, the background follows the frame, but for what was found."""
        if self._config.moving_only:
            seconds = self._config.learn_seconds
            self._background.follow(channels_of(frame), frame.stamp, blobs.box, seconds)

    def restart(self) -> None:
        """Nothing was learned."""
