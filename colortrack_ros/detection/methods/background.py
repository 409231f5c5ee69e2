"""Background subtraction: detects moving objects."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.detection.background_model import BackgroundModel
from colortrack_ros.detection.background_model import BackgroundModelConfig
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.blobs import clear
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.methods.base import Method
from colortrack_ros.detection.pixels import channels_of
from colortrack_ros.detection.shape import ShapeConfig
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter

SUBTRACTORS = {
    'mog2': lambda: cv2.createBackgroundSubtractorMOG2(detectShadows=False),
    'knn': lambda: cv2.createBackgroundSubtractorKNN(detectShadows=False),
}


@dataclass(frozen=True)
class BackgroundSubtractionConfig(BackgroundModelConfig, ShapeConfig):
    """Parameters of the motion mask; min_area also sets the area opening."""

    background_model: str = parameter(
        'median',
        'Of method background: how the background is learned.',
        choices=('median', *SUBTRACTORS),
        audience=EXPERT,
    )
    blur_sigma: float = parameter(
        1.5,
        'Of method background: standard deviation of the Gaussian before the threshold; 0 for '
        'none.',
        unit='px',
        limits=(0.0, 50.0),
        audience=EXPERT,
    )


class BackgroundSubtraction(Method):
    """Background subtraction and the clean-up of De Bem 2007, section 3.

    The difference is smoothed with a Gaussian and thresholded. An area opening then removes
    components smaller than min_area. The morphological opening follows with the steps that all
    methods share.
    """

    def __init__(self, config: BackgroundSubtractionConfig, background: BackgroundModel) -> None:
        self._config, self._model = config, background
        self.restart()

    def restart(self) -> None:
        """Create a new OpenCV subtractor."""
        name = self._config.background_model
        self._subtractor = SUBTRACTORS[name]() if name in SUBTRACTORS else None
        self._shape: tuple[int, ...] = ()

    def label(self, frame: Frame) -> LabelImage:
        """Label pixels that differ from the background with 1."""
        return self.label_of(self.smoothed(self.difference(channels_of(frame))))

    def smoothed(self, difference: NDArray) -> NDArray:
        """(H, W) the difference after the Gaussian [levels]."""
        if self._config.blur_sigma > 0:
            difference = cv2.GaussianBlur(difference, (0, 0), self._config.blur_sigma)
        return difference

    def label_of(self, difference: NDArray) -> LabelImage:
        """Label pixels whose smooth difference exceeds the threshold with 1."""
        threshold = self._config.difference_threshold if self._subtractor is None else 127.0
        image = LabelImage.empty(*difference.shape)
        cv2.threshold(difference, threshold, 1, cv2.THRESH_BINARY, dst=image.pixels)
        clear(image, find_blobs(image, 1, self._config.min_area - 1).runs)
        return image

    def difference(self, picture: NDArray) -> NDArray:
        """(H, W) distance to the background [levels], 0 before one is learned."""
        if self._subtractor is None:
            if not self._model.knows(picture):
                return np.zeros(picture.shape[:2], np.uint8)
            self._model.relight(picture)
            return self._model.difference(picture)
        # OpenCV's subtractors report all of the first picture as foreground.
        is_first, self._shape = self._shape != picture.shape, picture.shape
        difference = self._subtractor.apply(picture)
        return np.zeros_like(difference) if is_first else difference

    def learn(self, frame: Frame, blobs: BlobTable, kept: BlobTable) -> None:
        """Update the background outside all blobs, including those rejected by shape."""
        seconds = self._config.learn_seconds
        self._model.follow(channels_of(frame), frame.stamp, blobs, seconds)
