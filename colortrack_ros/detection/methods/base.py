"""What detection methods have in common."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.detection import blobs
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.blobs import Connect
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.pixels import Pixels
from colortrack_ros.detection.touching import Things


class Method:
    """Decides which pixels of a frame belong to which color.

    The constructor takes two arguments.

    :param config: of the detector, or the part of it that the method reads.
    :param background: learned by the detector so far, for methods that need it.
    """

    labels: int = 1
    """The largest label."""
    reads_yuv: bool = False
    """Whether the method reads YUV frames; if not, they are converted first."""
    connect: Connect = staticmethod(blobs.connect)
    """How to connect runs of pixels to blobs."""
    whole: LabelImage | None = None
    """Labels of the last frame before the method dropped possible parts of objects."""
    is_found: NDArray[np.bool_] | bool = False
    """(labels + 1,) by label, whether the limits of objects were estimated from the pictures.

    If so, boxes are those of the objects; otherwise, those of the mask."""

    small: BlobTable | None = None
    """Things of the last frame that the erosion leaves as they are, since it would remove them."""

    needs_color: bool = False
    """Whether nothing can be found in gray pictures."""

    @property
    def trouble(self) -> str:
        """A problem that the user should fix, and how; empty if there is none."""
        return ''

    def prepare(self, frame: Frame) -> Frame:
        """The frame that all steps read in place of this one."""
        return frame

    def label(self, frame: Frame) -> LabelImage:
        """Label each pixel: 0 for none, k + 1 for the color with index k."""
        raise NotImplementedError

    def closeness(self, frame: Frame, pixel: Pixels, label: NDArray) -> NDArray[np.float64]:
        """How well single pixels match their label, 0..1, with 1 for an exact match.

        :param pixel: (N,) rows and columns.
        :param label: (N,) of the blobs that contain the pixels.
        """
        return np.ones(len(label))

    def keep(self, frame: Frame, blobs: BlobTable, things: Things) -> NDArray[np.bool_]:
        """(N,) whether a blob may be an object, as far as the method can tell.

        :param things: the objects of the last frame.
        """
        return np.ones(len(blobs.area), bool)

    def learn(self, frame: Frame, blobs: BlobTable, kept: BlobTable) -> None:
        """Learn from the blobs of a frame, for the frames that follow.

        :param blobs: all of at least min_area.
        :param kept: the detected ones.
        """

    def take_over(self, before: 'Method') -> None:
        """Go on with what the method before has learned, if it holds with this configuration."""

    def restart(self) -> None:
        """Forget everything learned."""
