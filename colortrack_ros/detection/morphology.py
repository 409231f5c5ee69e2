"""Morphology of label images, separately for each color, with a square structuring element.

Pixels outside the picture neither erode nor grow a blob at its border. All functions work in place.
size is the side of the structuring element [px], 1 for none, and count is the largest label.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.label_image import WORD
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter

MAX_ELEMENT_SIZE = 99
"""Largest side of a structuring element [px]: limits the time that a parameter can cost."""

EROSION = np.ones((3, 3), np.uint8)
"""Structuring element of the detector's erosion, by default."""

EMPTY_ROWS = 32
"""Least number of unlabeled rows worth skipping: fewer cost less than an additional call."""


def _odd(size: int) -> None:
    if size % 2 == 0:
        raise ValueError(f'expected an odd number in 1..{MAX_ELEMENT_SIZE}, got {size}')


def _side(default: int, operation: str, **declared: Any) -> Any:
    """A field for the side of a structuring element."""
    return parameter(
        default,
        f'Side of the structuring element of the {operation}, odd; 1 leaves the mask as it is.',
        unit='px',
        limits=(1, MAX_ELEMENT_SIZE),
        valid=_odd,
        **declared,
    )


@dataclass(frozen=True)
class MorphologyConfig(Config):
    """How to clean the mask: closing (2.7), erosion (2.4), opening (2.6), in this order.

    Area, box and centroid are measured in the cleaned mask.
    """

    erosion_size: int = _side(3, 'erosion')
    opening_size: int = _side(1, 'opening, after the erosion', audience=EXPERT)
    closing_size: int = _side(
        1,
        'closing, before the erosion, which joins the parts of a striped object',
        audience=EXPERT,
    )


@lru_cache(maxsize=4)
def _square(size: int) -> NDArray[np.uint8]:
    return np.ones((size, size), np.uint8)


def erode(image: LabelImage, size: int, count: int) -> None:
    """Erosion, Pegoretti 2021, (2.4).

    The minimum label around a pixel is 0 unless its whole neighborhood is labeled. This erodes the
    masks of any number of colors in one pass, as long as no two colors are adjacent. If some are, a
    pixel stays if the minimum label is also the maximum.
    """
    if size == 1:
        return
    touch = count > 1 and not image.apart and colors_touch(image)
    most = cv2.dilate(image.padded, _square(size)) if touch else None
    margin = size // 2
    for top, bottom in image.row_groups(EMPTY_ROWS + size):
        part = image.pixels[max(top - margin, 0) : bottom + margin]
        cv2.erode(part, _square(size), dst=part)
    if most is not None:
        image.padded[image.padded != most] = 0


def colors_touch(image: LabelImage) -> bool:
    """Whether two colors are adjacent; occasionally True if they are only close."""
    filled, labels = image.content()
    words = labels.view(np.uint64).reshape(-1)
    # Above the first row, indexing wraps around to the last.
    above = image.words[filled - image.stride // WORD]
    flat = labels.reshape(-1)
    left = np.zeros_like(flat)
    left[1:] = flat[:-1]
    return _differ(words, above) or _differ(words, left.view(np.uint64))


def _differ(one: NDArray[np.uint64], other: NDArray[np.uint64]) -> bool:
    """Whether words of labels have different ones, not 0, in the same place."""
    differs = one != other
    first, second = one[differs].view(np.uint8), other[differs].view(np.uint8)
    return bool(((first != second) & (first != 0) & (second != 0)).any())


def open_(image: LabelImage, size: int, count: int) -> None:
    """Opening, Pegoretti 2021, (2.6)."""
    if size == 1:
        return
    labels = image.pixels
    for label in range(1, count + 1):
        mask = (labels == label).view(np.uint8)
        labels[mask != cv2.morphologyEx(mask, cv2.MORPH_OPEN, _square(size))] = 0


def close(image: LabelImage, size: int, count: int) -> None:
    """Closing, Pegoretti 2021, (2.7); where colors meet, the first one fills the gap."""
    if size == 1:
        return
    labels, image.filled, image.apart = image.pixels, None, False
    for label in range(1, count + 1):
        mask = (labels == label).view(np.uint8)
        closed = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, _square(size))
        labels[(labels == 0) & (closed != 0)] = label
