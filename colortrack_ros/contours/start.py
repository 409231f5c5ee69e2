"""New targets: what differs from the background, or from the picture before, in two pictures."""

from dataclasses import dataclass
from dataclasses import field

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.placing import along_box
from colortrack_ros.contours.placing import along_outline
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Areas:
    """Segmented areas of one picture.

    :ivar nodes: (K, n, 2) along their outlines, of positive area [px].
    :ivar miss: (K,) what the curves miss of them [px].
    :ivar center: (K, 2) their centroids [px].
    :ivar stamp: [ns].
    """

    nodes: Floats
    miss: Floats
    center: Floats
    stamp: int


@dataclass(frozen=True)
class Births:
    """New targets.

    :ivar nodes: (K, n, 2) [px].
    :ivar miss: (K,) what a curve of so many nodes misses of the outline [px].
    :ivar velocity: (K, 2) from the first picture to the second [px/s].
    """

    nodes: Floats = field(default_factory=lambda: np.zeros((0, 0, 2)))
    miss: Floats = field(default_factory=lambda: np.zeros(0))
    velocity: Floats = field(default_factory=lambda: np.zeros((0, 2)))


class Start:
    """Segmentation, and correspondence of two pictures by nearest neighbor (De Bem 2007, 3, 5.3).

    Subtraction, Gaussian, threshold, area opening and opening are those of the detector's method
    `background`. That it learns its background from the picture before makes it frame differencing.
    """

    def __init__(self, config: ContourConfig) -> None:
        self.configure(config)

    def configure(self, config: ContourConfig) -> None:
        """Take another configuration; what was learned of the background stays."""
        detector = DetectorConfig(
            method='background',
            difference_threshold=config.difference_threshold,
            blur_sigma=config.blur_sigma,
            min_area=config.min_area,
            erosion_size=1,
            opening_size=config.opening_size,
            learn_seconds=config.learn_seconds,
        )
        if hasattr(self, '_detector'):
            self._detector.configure(detector)
        else:
            self._detector = Detector(detector)
            self.restart()
        self._config = config
        self._spline = Spline(config.points, interpolating=config.interpolating)

    def restart(self) -> None:
        """Forget the background."""
        self._detector.learn_background()
        self._before: Areas | None = None
        self._last: Frame | None = None
        self._due: int | None = None

    def search(self, frame: Frame, outlines: Floats) -> Births:
        """New targets, in a picture in which it is time to look for them.

        :param outlines: (N, P, 2) of the targets that there are [px].
        """
        last, self._last = self._last, frame if self._config.start == 'difference' else None
        if self._due is not None and frame.stamp < self._due and self._before is None:
            return Births()
        before, self._before = self._before, None
        self._due = frame.stamp + round(self._config.start_interval * NANOSECONDS)
        if self._config.start == 'difference':
            if last is None or last.image.shape != frame.image.shape:
                return Births()
            self._detector.learn_background()
            self._detector.detect(last)
        areas = self._segment(frame, outlines)
        if before is None or not len(before.center) or areas.stamp <= before.stamp:
            self._before = areas if len(areas.center) else None
            return Births()
        return self._matched(before, areas)

    def _segment(self, frame: Frame, outlines: Floats) -> Areas:
        """The areas that are wholly in the picture and belong to no target."""
        rows = self._detector.detect(frame).rows
        mask, (height, width) = self._detector.mask, frame.image.shape[:2]
        center, nodes, miss = [], [], []
        shapes = outlines.astype(np.float32)
        for row in rows:
            u, v, w, h = (int(row[name]) for name in ('box_u', 'box_v', 'box_w', 'box_h'))
            place = float(row['u']), float(row['v'])
            whole = u > 0 and v > 0 and u + w < width and v + h < height
            if not whole or any(cv2.pointPolygonTest(s, place, False) >= 0 for s in shapes):
                continue
            if self._config.outline == 'box':
                nodes.append(along_box((u, v, w, h), self._spline))
                miss.append(0.0)
            else:
                part = np.ascontiguousarray(mask[v : v + h, u : u + w])
                found, _ = cv2.findContours(part, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
                points = max(found, key=len)[:, 0] + np.array([u, v], float)
                placed = along_outline(points, self._spline)
                nodes.append(placed[0])
                miss.append(placed[1])
            center.append(place)
        n = self._config.points
        return Areas(
            np.array(nodes).reshape(-1, n, 2),
            np.array(miss),
            np.array(center).reshape(-1, 2),
            frame.stamp,
        )

    def _matched(self, before: Areas, areas: Areas) -> Births:
        """Areas that are each other's nearest in the two pictures."""
        if not len(areas.center):
            return Births()
        gap = np.linalg.norm(areas.center[:, None] - before.center, axis=2)
        nearest = gap.argmin(axis=1)
        mutual = gap.argmin(axis=0)[nearest] == np.arange(len(gap))
        seconds = (areas.stamp - before.stamp) / NANOSECONDS
        velocity = (areas.center - before.center[nearest]) / seconds
        return Births(areas.nodes[mutual], areas.miss[mutual], velocity[mutual])


