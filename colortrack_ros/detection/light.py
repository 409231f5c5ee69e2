"""Changing light: corrects pictures to the initial light, or lets colors follow it."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.growth import NO_LIGHT
from colortrack_ros.detection.lab import Triple
from colortrack_ros.detection.reference import LAB_RANGES
from colortrack_ros.detection.reference import MAX_TOLERANCE
from colortrack_ros.detection.reference import ReferenceColor

BALANCE_PIXELS = 16384
"""Number of pixels from which the light is estimated: their mean is known to 1/128 of their
spread."""

FOLLOW_SECONDS = 1.0
"""Time constant of a reference color that follows detections [s]. In `python
benchmark/detection_quality.py --constants` centroids are off by 0.44 px with half of it, 0.47 with
it, and 0.70 with twice."""

FOLLOW_STEP = 1.0
"""Least change of a color that rebuilds the tables [CIELAB units]: below the just noticeable
difference of about 2.3 (Mahy 1994)."""

ALPHA_CHANNEL = 3
"""Index of the alpha channel in bgra8 and rgba8, which does not depend on light."""


class GrayWorld:
    """Keeps the mean of each channel at its value in the first picture.

    This is a relative form of the gray-world assumption that the mean of a scene is constant:
    colors picked in the initial light remain valid.
    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Take the light of the next picture as the reference."""
        self._first = np.zeros(0)

    def balance(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The picture in the initial light, with the same shape; the first one is returned as it
        is.
        """
        step = max(1, int(np.sqrt(picture.shape[0] * picture.shape[1] / BALANCE_PIXELS)))
        mean = np.maximum(np.atleast_1d(picture[::step, ::step].mean(axis=(0, 1))), 1.0)
        if self._first.shape != mean.shape:
            self._first = mean
        gain = self._first / mean
        gain[ALPHA_CHANNEL:] = 1.0
        levels = np.clip(np.rint(np.arange(256)[:, None] * gain), 0, 255).astype(np.uint8)
        if (levels == np.arange(256)[:, None]).all():
            return picture
        balanced: NDArray[np.uint8] = np.empty(picture.shape, np.uint8)
        cv2.LUT(picture, levels[:, None], dst=balanced)
        return balanced


class ColorFollower:
    """Lets reference colors follow their detections, slowly and within a bound.

    In less light, the background comes closer in color, and the tolerance shrinks. It shrinks by
    half as much, because camera noise does not. Inverted colors stay, and so do those whose
    tolerance is estimated: they follow the light by themselves.

    :param colors: as configured.
    :param bound: largest shift of a color [CIELAB units].
    """

    def __init__(self, colors: tuple[ReferenceColor, ...], bound: float) -> None:
        self._colors, self._bound = colors, bound
        self._follows = [not (color.inverted or color.is_sought) for color in colors]
        self._lab = np.array([color.lab for color in colors])
        self._way = np.zeros_like(self._lab)
        self._taken = self._way.copy()
        self._stamp: int | None = None

    def follow(
        self, lab: NDArray[np.float64], color: NDArray[np.integer], stamp: int
    ) -> tuple[ReferenceColor, ...] | None:
        """Move toward the mean of the detected pixels with the time constant FOLLOW_SECONDS.

        :param lab: (N, 3) pixels of blobs.
        :param color: (N,) index of their color.
        :param stamp: of the frame [ns].
        :returns: the colors, or None while they are within FOLLOW_STEP of those last returned.
        """
        elapsed = 0 if self._stamp is None else max(stamp - self._stamp, 0) / NANOSECONDS
        self._stamp = stamp
        for k in np.unique(color):
            if not self._follows[k]:
                continue
            mean = lab[color == k].mean(axis=0)
            way = self._way[k]
            way += (mean - self._lab[k] - way) * -np.expm1(-elapsed / FOLLOW_SECONDS)
            length = float(np.linalg.norm(way))
            if length > self._bound:
                way *= self._bound / length
        if np.abs(self._way - self._taken).max() < FOLLOW_STEP:
            return None
        self._taken = self._way.copy()
        low, high = np.array([limits[1:] for limits in LAB_RANGES]).T
        lab = np.clip(self._lab + self._way, low, high)
        light = (lab[:, 0] - NO_LIGHT[0]) / (self._lab[:, 0] - NO_LIGHT[0])
        return tuple(
            _moved(color, (L, a, b), scale) if follows else color
            for color, follows, (L, a, b), scale in zip(
                self._colors, self._follows, lab.tolist(), np.sqrt(light).tolist(), strict=True
            )
        )


def _moved(color: ReferenceColor, lab: Triple, scale: float) -> ReferenceColor:
    """The color in different light, with its tolerance scaled."""
    tolerance, dL, da, db = (min(scale * x, MAX_TOLERANCE) for x in (color.tolerance, *color.axes))
    moved = replace(color, lab=lab, tolerance=tolerance, tolerance_lab=(dL, da, db))
    way = np.subtract(lab, color.lab)
    samples, others = (
        tuple((L, a, b) for L, a, b in (np.array(shades).reshape(-1, 3) + way).tolist())
        for shades in (color.samples, color.others)
    )
    return replace(moved, samples=samples, others=others)
