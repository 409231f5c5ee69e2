"""Channel difference: detects the largest object of a primary color (Red object, (8) to (12))."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.detection.background_model import BackgroundModel
from colortrack_ros.detection.blobs import as_one
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.methods.base import Method
from colortrack_ros.detection.pixels import Pixels
from colortrack_ros.detection.pixels import rgb_of
from colortrack_ros.detection.pixels import split_rgb
from colortrack_ros.detection.touching import Things
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import DOCUMENT
from colortrack_ros.parameters import parameter

CHANNELS = ('red', 'green', 'blue')
REGION_SHARE = 0.10
"""Half the side of the region of interest, as a share of the picture's width and height: 10 % in
Red object, (11) and (12)."""


@dataclass(frozen=True)
class ChannelDifferenceConfig(Config):
    """Which channel to compare with the others."""

    channel: str = parameter(
        'red',
        'Of method channel_difference: the channel from which the other two are subtracted.',
        choices=CHANNELS,
        audience=DOCUMENT,
    )
    channel_threshold: int = parameter(
        60,
        'Of method channel_difference: pixels with a greater difference belong to the object.',
        unit='levels',
        limits=(0, 254),
        audience=DOCUMENT,
    )
    largest_object: str = parameter(
        'blob',
        'Of method channel_difference: what is taken for the largest object. blob: the connected '
        'pixels of the greatest area; region: as in the document, all pixels within 10 % of the '
        'picture around the peaks of the projections, which cuts large objects, and finds nothing '
        'where two objects have a peak each.',
        choices=('blob', 'region'),
        audience=DOCUMENT,
    )


class ChannelDifference(Method):
    """R - G - B above a threshold, or another channel minus the other two.

    The document looks for the largest object, and takes the mask pixels in a region for it. With
    the mask O, row sums H (8) and column sums V (9), the region is around x = argmax V, y = argmax
    H (10). The centroid is that of all mask pixels within 10 % of the picture around (x, y), (11)
    and (12), connected or not. With two objects, one may have the peak in H and the other in V, and
    objects larger than the region are cut. The largest blob has neither flaw.
    """

    needs_color = True

    def __init__(self, config: ChannelDifferenceConfig, background: BackgroundModel) -> None:
        self._channel = CHANNELS.index(config.channel)
        self._threshold = config.channel_threshold
        self._by_region = config.largest_object == 'region'
        if self._by_region:
            self.connect = as_one

    def label(self, frame: Frame) -> LabelImage:
        """Label the mask with 1, limited to the region of interest if there is one."""
        channels = split_rgb(frame.image, frame.encoding)
        minuend = channels.pop(self._channel)
        # Saturates at 0, which no threshold lets through.
        difference = cv2.subtract(cv2.subtract(minuend, channels[0]), channels[1])
        image = LabelImage.empty(*frame.image.shape[:2])
        cv2.threshold(difference, self._threshold, 1, cv2.THRESH_BINARY, dst=image.pixels)
        if self._by_region:
            _clear_outside(image)
        return image

    def closeness(self, frame: Frame, pixel: Pixels, label: NDArray) -> NDArray[np.float64]:
        """Difference of the channels over the largest possible one."""
        return np.clip(self._difference(frame, pixel) / 255, 0, 1)

    def _difference(self, frame: Frame, pixel: Pixels) -> NDArray[np.float64]:
        """(N,) the channel minus both others."""
        rgb = rgb_of(frame.image[pixel], frame.encoding).astype(np.float64)
        others = np.delete(rgb, self._channel, axis=1).sum(axis=1)
        return np.asarray(rgb[:, self._channel] - others)

    def keep(self, frame: Frame, blobs: BlobTable, things: Things) -> NDArray[np.bool_]:
        """Keep only the first blob, which is the largest."""
        return np.arange(len(blobs.area)) == 0


def _clear_outside(image: LabelImage) -> None:
    """Clear the mask outside the region of interest, in place."""
    height, width = image.pixels.shape
    v, u = np.divmod(image.positions(), image.stride)
    if not v.size:
        return
    y, x = np.bincount(v).argmax(), np.bincount(u).argmax()
    outside = (np.abs(v - y) > REGION_SHARE * height) | (np.abs(u - x) > REGION_SHARE * width)
    image.pixels[v[outside], u[outside]] = 0
