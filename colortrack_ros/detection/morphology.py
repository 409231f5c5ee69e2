"""Morphology of label images, each color for itself, with a square structuring element.

What lies outside of the picture neither erodes nor grows a blob at its border.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

Labels = NDArray[np.uint8]


def _square(size: int) -> NDArray[np.uint8]:
    return np.ones((size, size), np.uint8)


def erode(labels: Labels, size: int) -> None:
    """Erosion, Pegoretti 2021, (2.4), in place.

    A pixel stays where its whole neighborhood has one label: where the least label around it is
    also the greatest. That is the erosion of each color's mask, in two passes for any number.

    :param labels: (H, W).
    :param size: side of the structuring element [px], 1 for none.
    """
    if size == 1:
        return
    greatest = cv2.dilate(labels, _square(size))
    cv2.erode(labels, _square(size), dst=labels)
    labels[labels != greatest] = 0


def open_(labels: Labels, size: int, count: int) -> None:
    """Opening, Pegoretti 2021, (2.6), in place.

    :param labels: (H, W), 0 to count.
    :param size: side of the structuring element [px], 1 for none.
    """
    if size == 1:
        return
    for label in range(1, count + 1):
        mask = (labels == label).view(np.uint8)
        opened = cv2.morphologyEx(mask, cv2.MORPH_OPEN, _square(size))
        labels[mask != opened] = 0


def close(labels: Labels, size: int, count: int) -> None:
    """Closing, Pegoretti 2021, (2.7), in place; where colors meet, the first one fills.

    :param labels: (H, W), 0 to count.
    :param size: side of the structuring element [px], 1 for none.
    """
    if size == 1:
        return
    for label in range(1, count + 1):
        mask = (labels == label).view(np.uint8)
        closed = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, _square(size))
        labels[(labels == 0) & (closed != 0)] = label
