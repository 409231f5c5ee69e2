"""Pictures as the window tracker reads them."""

from dataclasses import replace

import numpy as np

from colortrack_ros.data import Frame
from colortrack_ros.encodings import check
from colortrack_ros.encodings import plain


def legible(frame: Frame) -> Frame:
    """A frame whose picture can be searched: of one without pixels, a single black one.

    Drivers may send those while they start. Nothing is seen there, as where a lens is covered.

    :raises ValueError: if the encoding is unknown or does not fit the picture's shape.
    """
    check(frame)
    frame = plain(frame)
    if frame.image.size:
        return frame
    return replace(frame, image=np.zeros((1, 1, *frame.image.shape[2:]), np.uint8))
