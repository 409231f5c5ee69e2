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
from colortrack_ros.detection.pixels import rgb_of

if TYPE_CHECKING:
    from colortrack_ros.detection.config import DetectorConfig


class Color:
    """Color distance (2.1) and threshold (2.2)."""

    connect = staticmethod(connect)

    def __init__(self, config: 'DetectorConfig', background: BackgroundModel) -> None:
        self.labels = len(config.colors)
        self._table = ColorTable(config.colors, config.threads)

    def label(self, frame: Frame) -> LabelImage:
        """The reference color that each pixel is within tolerance of."""
        return self._table.label(frame.image, frame.encoding)

    def closeness(
        self, frame: Frame, pixel: tuple[NDArray[np.intp], NDArray[np.intp]], label: NDArray
    ) -> NDArray[np.float64]:
        """1 - D / tolerance."""
        return self._table.closeness(rgb_of(frame.image[pixel], frame.encoding), label)

    def learn(self, frame: Frame, blobs: Blobs) -> None:
        """Nothing: every frame stands for itself."""

    def restart(self) -> None:
        """Nothing was learned."""
