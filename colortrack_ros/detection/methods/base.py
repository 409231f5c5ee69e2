"""What every way to tell objects from the rest has in common."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.blobs import Connect
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.pixels import Pixels


class Method(Protocol):
    """Tells which pixels of a frame belong to which color.

    It is made with two arguments.

    :param config: of the detector, or the part of it that the method reads.
    :param background: what the detector has learned so far, for methods that need it.
    """

    @property
    def labels(self) -> int:
        """The greatest label there is."""

    @property
    def reads_yuv(self) -> bool:
        """Whether it takes frames with YUV; others have red, green and blue, or gray levels."""

    @property
    def connect(self) -> Connect:
        """How runs of pixels become blobs."""

    @property
    def whole(self) -> LabelImage | None:
        """The labels of the last frame before some were dropped that may be parts of objects."""

    @property
    def doubt(self) -> NDArray[np.float64] | float:
        """(labels + 1,) by label, how far centroids are off as nobody knows where objects end.

        That is a standard deviation along one axis [shares of the width of the blur]; one number
        for all labels will do.
        """

    @property
    def is_found(self) -> NDArray[np.bool_] | bool:
        """(labels + 1,) by label, whether where objects end was found in the pictures.

        Then the boxes of blobs are those of objects; else they are those of the mask.
        """

    @property
    def trouble(self) -> str:
        """What a person should know and do; empty when all is well."""

    def label(self, frame: Frame) -> LabelImage:
        """The label of each pixel: 0 for none, k + 1 for the color with the index k."""

    def closeness(self, frame: Frame, pixel: Pixels, label: NDArray) -> NDArray[np.float64]:
        """How well single pixels fit to their label, 0..1, 1 when exactly.

        :param pixel: (N,) rows and columns.
        :param label: (N,) of the blobs that the pixels are in.
        """

    def end_share(
        self, frame: Frame, inside: Pixels, outside: Pixels, label: NDArray
    ) -> NDArray[np.float64]:
        """Where on the blurred outline of a blob, which mixes what is on its sides, it ends.

        :param inside, outside: N pixels on either side of an outline.
        :param label: (N,) of the blobs.
        :returns: (N,) share of the inside in the mix there, 0..1; half if nothing is known.
        """

    def keep(self, frame: Frame, blobs: BlobTable) -> NDArray[np.bool_]:
        """(N,) whether a blob may be an object, as far as the method can tell."""

    def learn(self, frame: Frame, blobs: BlobTable, kept: BlobTable) -> None:
        """Take what was found in the frame into account from the next frame on.

        :param blobs: all of at least min_area.
        :param kept: those of them that are detected.
        """

    def restart(self) -> None:
        """Forget what was learned."""
