"""Changes of the light on a whole picture, as those of a lamp or of a camera's exposure."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.growth import NO_LIGHT
from colortrack_ros.detection.lab import linear_from_lab
from colortrack_ros.detection.lab import linear_from_srgb

COMPARED_PIXELS = 4096
"""Number of means of pixels that are compared, which have less noise. Assumed: half of them are
known to 1 % by their binomial spread."""

DARKEST, LIGHTEST = 10, 245
"""Values between which a channel shows how much light there is: noise or the limits of the camera
decide on others. Assumed."""

LEAST_SHOWN = 0.1
"""Share of all values that must be between these limits. Assumed: in front of a white or a black
background nothing but the things themselves is, and these move."""

MAJORITY = 0.8
"""Share of the channels that get lighter, or darker, when the light changes. Moving things and
cameras change them both ways: 0.5 to 0.76 in 45 public films, and 0.8 to 1.0 where the exposure
changes (benchmark/notes/detector.md, Light that changes)."""

LEAST_LIGHT_CHANGE = 0.03
"""Change of L + 16 that is told, relative; smaller ones are summed up until they are as large.
Assumed: at L = 50 it is the just noticeable difference of 2 (Mahy 1994)."""


class LightChange:
    """Compares each picture with the one before it."""

    def __init__(self) -> None:
        self._last, self._rest = np.zeros(0, np.float32), 1.0

    def change(self, picture: NDArray[np.uint8]) -> float:
        """The factor by which L + 16, a, and b of all things have changed; 1 if by little.

        They are proportional to the cube root of the light (CIE 15:2004), of which the median of
        all channels' changes is taken.

        :param picture: (H, W, C) or (H, W).
        """
        height, width = picture.shape[:2]
        step = max(1, int(np.sqrt(height * width / COMPARED_PIXELS)))
        size = max(width // step, 1), max(height // step, 1)
        rows = picture[:: 1 + step // 4].astype(np.float32)
        mean = cv2.resize(rows, size, interpolation=cv2.INTER_AREA)
        now = np.atleast_3d(mean)[..., :3].copy()
        last, self._last = self._last, now
        if last.shape != now.shape:
            return 1.0
        shown = (np.minimum(last, now) >= DARKEST) & (np.maximum(last, now) <= LIGHTEST)
        ratio = linear_from_srgb(now[shown]) / linear_from_srgb(last[shown])
        alike = max(np.count_nonzero(ratio > 1), np.count_nonzero(ratio < 1))
        if ratio.size < LEAST_SHOWN * now.size or alike < MAJORITY * ratio.size:
            return 1.0
        scale, self._rest = self._rest * float(np.cbrt(np.median(ratio))), 1.0
        if abs(scale - 1) > LEAST_LIGHT_CHANGE:
            return scale
        self._rest = scale
        return 1.0


def in_light(extent: Extent, scale: float) -> Extent:
    """The extent of a color in another light.

    :param scale: of L + 16, a, and b.
    """
    L, a, b = (NO_LIGHT + scale * (np.array(extent.lab) - NO_LIGHT)).tolist()
    dL, da, db = (scale * axis for axis in extent.axes)
    return replace(extent, lab=(L, a, b), axes=(dL, da, db))


def as_shown(extent: Extent) -> Extent:
    """The extent of a color as a camera shows it: it gets no lighter than its lightest channel."""
    lightest = float(linear_from_lab(extent.lab).max())
    return in_light(extent, float(np.cbrt(1 / lightest))) if lightest > 1 else extent
