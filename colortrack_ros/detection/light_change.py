"""Changes of the light on a whole picture, as those of a lamp or of a camera's exposure."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.detection.extent import Extent
from colortrack_ros.detection.growth import NO_LIGHT
from colortrack_ros.detection.lab import lab_from_linear
from colortrack_ros.detection.lab import linear_from_lab
from colortrack_ros.detection.lab import linear_from_srgb
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.pixels import split_rgb

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

MOST_UNEVEN = 2 * LEAST_LIGHT_CHANGE
"""Median difference of the changes of L + 16 from their median, relative, mean of the channels that
change, above which another scene is in sight: light changes all of it alike. In real changes it is
up to 0.03, at cuts from 0.3 (benchmark/notes/detector.md, Light that is not). One channel may have
more, as a dark one, whose steps are coarse: blue of `cups` 0.085 where the light triples."""

SAME_LIGHT = np.ones(3)


class LightChange:
    """Compares each picture with the one before it."""

    def __init__(self) -> None:
        self._last, self._rest = np.zeros(0, np.float32), SAME_LIGHT

    def change(self, frame: Frame) -> Floats:
        """The factors by which linear red, green, and blue of all things have changed, (3,).

        They are 1 if by little. Each is the median of a channel's changes; the light of another
        color scales channels by different factors (von Kries 1902).

        :param frame: with an encoding of ENCODINGS.
        """
        now = _means(frame)
        last, self._last = self._last, now
        if last.shape != now.shape:
            return SAME_LIGHT
        pairs = zip(last.T, now.T, strict=True)
        gains, uneven = np.array([_gain(*pair) for pair in pairs]).T
        known = ~np.isnan(gains)
        if not known.any() or (gains == 0).any():
            return SAME_LIGHT
        if uneven.sum() > MOST_UNEVEN * np.count_nonzero(uneven):
            return SAME_LIGHT
        gains = self._rest * np.where(known, gains, np.nanmean(gains))
        if np.abs(np.cbrt(gains) - 1).max() <= LEAST_LIGHT_CHANGE:
            self._rest = gains
            return SAME_LIGHT
        risen = _limits_passed(now) - _limits_passed(last)
        if (risen * np.sign(gains - 1) <= -LEAST_SHOWN).any():
            return SAME_LIGHT
        self._rest = SAME_LIGHT
        return gains


def _means(frame: Frame) -> NDArray[np.float32]:
    """Red, green, and blue of means of pixels, (n, 3)."""
    height, width = frame.image.shape[:2]
    step = max(1, int(np.sqrt(height * width / COMPARED_PIXELS)))
    size = max(width // step, 1), max(height // step, 1)
    rows = frame.image[:: 1 + step // 4].astype(np.float32)
    mean: Any = cv2.resize(rows, size, interpolation=cv2.INTER_AREA)
    return np.stack([channel.reshape(-1) for channel in split_rgb(mean, frame.encoding)], axis=1)


def _gain(last: NDArray[np.float32], now: NDArray[np.float32]) -> tuple[float, float]:
    """Median change of a linear channel, (n,); NaN if unknown, 0 if it is not that of the light.

    And the median difference of the changes of L + 16 from theirs, relative; 0 if they are little.
    """
    shown = (np.minimum(last, now) >= DARKEST) & (np.maximum(last, now) <= LIGHTEST)
    ratio = linear_from_srgb(now[shown]) / linear_from_srgb(last[shown])
    if ratio.size < LEAST_SHOWN * now.size:
        return np.nan, 0.0
    gain = float(np.median(ratio))
    is_little = abs(np.cbrt(gain) - 1) <= LEAST_LIGHT_CHANGE
    if max(np.count_nonzero(ratio > 1), np.count_nonzero(ratio < 1)) < MAJORITY * ratio.size:
        return (1.0 if is_little else 0.0), 0.0
    return gain, 0.0 if is_little else float(np.median(np.abs(np.cbrt(ratio / gain) - 1)))


def _limits_passed(picture: NDArray[np.float32]) -> Floats:
    """(3,) mean number of limits, of two, below the values of a channel, (n, 3).

    A color that changes past a limit cannot be compared, but tells whether there is more light.
    """
    above = [np.count_nonzero(picture >= limit, axis=0) for limit in (DARKEST, LIGHTEST)]
    return np.asarray(sum(above) / len(picture))


def in_light(extent: Extent, gains: Floats) -> Extent:
    """The extent of a color in another light.

    :param gains: (3,) of linear red, green, and blue.
    """
    lab = lab_in_light(extent.lab, gains)
    scale = (lab[0] - NO_LIGHT[0]) / (extent.lab[0] - NO_LIGHT[0])
    dL, da, db = (scale * axis for axis in extent.axes)
    return replace(extent, lab=lab, axes=(dL, da, db))


def lab_in_light(lab: Triple, gains: Floats) -> Triple:
    """A color in another light; gains: (3,) of linear red, green, and blue."""
    L, a, b = lab_from_linear(linear_from_lab(lab) * gains).tolist()
    return L, a, b


def as_shown(extent: Extent) -> Extent:
    """The extent of a color as a camera shows it: it gets no lighter than its lightest channel."""
    lightest = lightest_channel(extent.lab)
    return in_light(extent, SAME_LIGHT / lightest) if lightest > 1 else extent


def lightest_channel(lab: Triple) -> float:
    """The largest of linear red, green, and blue; above 1 for colors that no camera shows."""
    return float(linear_from_lab(lab).max())
