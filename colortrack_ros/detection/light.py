"""Light that changes: pictures as they would be in the first light, and colors that follow it."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.reference import LAB_RANGES
from colortrack_ros.detection.reference import MAX_TOLERANCE
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.reference import Triple

BALANCE_PIXELS = 16384
"""Pixels that the light is estimated from: their mean is known to 1/128 of their spread."""

FOLLOW_SECONDS = 1.0
"""Time constant of a reference color that follows what is found [s]: in
`python benchmark/detection_quality.py --constants` centroids are off by 0.44 px at half of it, 0.47
at it, and 0.70 at twice."""

FOLLOW_STEP = 1.0
"""How far it has to go before the tables are rebuilt [CIELAB units]: less than one can see, which
is a distance of about 2.3 (Mahy 1994)."""

LAB_OFFSET = 16.0
"""The 16 in L = 116 f - 16 (CIE 1976): L + 16, a and b are proportional to the cube root of the
light, and so are distances of colors."""

ALPHA_CHANNEL = 3
"""Index of the first channel that is not light, in bgra8 and rgba8."""


class GrayWorld:
    """Keeps the mean of each channel at what it was in the first picture.

    That is the gray-world assumption, the mean of a scene does not change, but relative: the
    colors that were picked in the first light stay what they were.
    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Take the light of the next picture as the first."""
        self._first = np.zeros(0)

    def balance(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The picture in the first light, of the same shape; at first the picture itself."""
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
    """Lets reference colors follow what is found of them, slowly and not far.

    In less light the background comes nearer, and the tolerance shrinks; half as much, because
    the noise of the camera does not.

    :param colors: as configured.
    :param bound: how far one may go [CIELAB units].
    """

    def __init__(self, colors: tuple[ReferenceColor, ...], bound: float) -> None:
        self._colors, self._bound = colors, bound
        self._lab = np.array([color.lab for color in colors])
        self._way = np.zeros_like(self._lab)
        self._taken = self._way.copy()
        self._stamp: int | None = None

    def follow(
        self, lab: NDArray[np.float64], color: NDArray[np.integer], stamp: int
    ) -> tuple[ReferenceColor, ...] | None:
        """Go towards the mean of the pixels found, with the time constant FOLLOW_SECONDS.

        :param lab: (N, 3) pixels of blobs.
        :param color: (N,) index of their color.
        :param stamp: of the frame [ns].
        :returns: the colors, or None while they are within FOLLOW_STEP of those returned last.
        """
        elapsed = 0 if self._stamp is None else max(stamp - self._stamp, 0) / NANOSECONDS
        self._stamp = stamp
        for k in np.unique(color):
            if self._colors[k].inverted:
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
        light = (lab[:, 0] + LAB_OFFSET) / (self._lab[:, 0] + LAB_OFFSET)
        return tuple(
            _moved(color, (L, a, b), scale)
            for color, (L, a, b), scale in zip(
                self._colors, lab.tolist(), np.sqrt(light).tolist(), strict=True
            )
        )


def _moved(color: ReferenceColor, lab: Triple, scale: float) -> ReferenceColor:
    """The same color in another light, with the tolerance scaled."""
    tolerance, dL, da, db = (min(scale * x, MAX_TOLERANCE) for x in (color.tolerance, *color.axes))
    moved = replace(color, lab=lab, tolerance=tolerance, tolerance_lab=(dL, da, db))
    way = np.subtract(lab, color.lab)
    samples, others = (
        tuple((L, a, b) for L, a, b in (np.array(shades).reshape(-1, 3) + way).tolist())
        for shades in (color.samples, color.others)
    )
    return replace(moved, samples=samples, others=others)
