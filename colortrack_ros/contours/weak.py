"""Weak differences from the background that continue strong ones."""

import cv2
import numpy as np

from colortrack_ros.contours.areas import Mask
from colortrack_ros.data import Bools
from colortrack_ros.detection.background_model import Picture

WEAK_SHARE = 0.65
"""Share of difference_threshold that a weak difference exceeds. In a prototype the mean MOTA and
precision of eight clips were 0.47, 0.85, with 0.5 0.44, 0.82, with strong differences alone 0.40,
0.80 (benchmark/notes/contours.md)."""

WEAK_CONTRAST = 0.2
"""Least weak difference as a share of the background's level: soft shadows dim by less, and noise
grows with the level. The same means with 0.15 and 0.3: 0.43, 0.83; 0.44, 0.83."""


def with_weak(
    strong: Mask, difference: Picture, background: Picture, threshold: float, settled: Bools | None
) -> Mask:
    """Return a mask with the weak differences that are connected to it (Canny's hysteresis).

    A dark coat before a dark wall differs by less than the threshold, so head, arms, and legs come
    apart.

    :param strong: (H, W), not 0 where the difference exceeds the threshold.
    :param difference: (H, W) smoothed, mean of the channels [levels].
    :param background: (H, W, channels).
    :param threshold: of strong differences [levels].
    :param settled: (H, W) where the background is known for good, None for everywhere: what is left
        of somebody in it differs weakly all around.
    """
    if not strong.any():
        return strong
    channels = background.shape[2]
    least = cv2.transform(background, np.full((1, channels), WEAK_CONTRAST / channels))
    least = np.maximum(least, int(WEAK_SHARE * threshold))
    weak = cv2.compare(difference, least, cv2.CMP_GT)
    if settled is not None:
        weak[~settled] = 0
    weak[strong > 0] = 1
    count, label = cv2.connectedComponents(weak)
    kept = np.zeros(count, np.uint8)
    kept[label[strong > 0]] = 1
    return kept[label]
