"""New targets: what differs from the background, or from the picture before, in two pictures."""

from dataclasses import dataclass
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.lines import find_edges
from colortrack_ros.contours.placing import along_outline
from colortrack_ros.contours.placing import equally_spaced
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import Columns
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig

Floats = NDArray[np.float64]


LEAST_LEARNED = 5
"""Pictures that a background is learned from, at least."""


MAX_FOREGROUND = 0.3
"""Where more of the picture differs it is the background that moves: nothing starts."""


@dataclass(frozen=True)
class Areas(Columns):
    """Segmented areas.

    :ivar outline: (K,) their outlines, closed polygons (P, 2) [px].
    :ivar nodes: (K, n, 2) along them, of positive area [px].
    :ivar misfit: (K,) what curves through the nodes miss of them, root mean square [px], 0 where
        that is not known.
    :ivar center: (K, 2) their centroids [px].
    :ivar velocity: (K, 2) of their centroids, 0 where it is not known [px/s].
    :ivar target: (K,) index of the target that an area is of, -1 for none.
    """

    outline: NDArray[np.object_]
    nodes: Floats
    misfit: Floats
    center: Floats
    velocity: Floats
    target: NDArray[np.intp]


class Initiation:
    """Segmentation, and correspondence of two pictures by nearest neighbor (De Bem 2007, 3, 5.3).

    Subtraction, Gaussian, threshold, area opening and opening are those of the detector's method
    `background`. Where it learns its background from the picture of the look before alone, it is
    frame differencing. Where a target has been it differs as well, but there are no edges.
    """

    def __init__(self, config: ContourConfig) -> None:
        self._detector = Detector(DetectorConfig())
        self.configure(config)
        self.learn_background()
        self.restart()

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
        self._detector.configure(detector)
        self._config = config
        self._spline = Spline(config.points, interpolating=config.interpolating)
        self._before = self._none()

    def learn_background(self) -> None:
        """Forget the background: the next picture is the first of a new one."""
        self._detector.learn_background()
        self._looks, self._shape = 0, ()
        self._learning_until: int | None = None

    def restart(self) -> None:
        """Forget the picture before, but not the background."""
        self._before, self._seen = self._none(), 0
        self._reference: Frame | None = None
        self._last: Frame | None = None
        self._due: int | None = None

    def is_time(self, stamp: int) -> bool:
        """Whether it is time to look for new targets [ns]."""
        due = self._due is None or stamp >= self._due
        return due or len(self._before) > 0 or self._is_learning(stamp)

    def search(
        self, frame: Frame, outlines: Floats, worn: NDArray[np.bool_]
    ) -> tuple[Areas, Areas]:
        """Areas of new targets in a picture.

        :param outlines: (N, P, 2) of the targets that there are [px].
        :param worn: (N,) which of them want new nodes.
        :return: also areas of worn targets.
        """
        if self._shape != frame.image.shape:
            self._shape, self._looks, self._before = frame.image.shape, 0, self._none()
        self._looks += 1
        self._due = frame.stamp + round(self._config.start_interval * NANOSECONDS)
        before, self._before = self._before, self._none()
        if self._config.start == 'difference' and not self._compare(frame, again=len(before) > 0):
            return self._none(), self._none()
        areas = self._segment(frame, outlines, worn)
        new = areas.take(areas.target < 0)
        dt, self._seen = (frame.stamp - self._seen) / NANOSECONDS, frame.stamp
        if not len(before) or dt <= 0:
            self._before, new = new, self._none()
        new, again = _matched(before, new, dt), areas.take(areas.target >= 0)
        return self._refined(new), self._refined(again)

    def _none(self) -> Areas:
        nodes, pairs = np.zeros((0, self._config.points, 2)), np.zeros((0, 2))
        return Areas(np.zeros(0, object), nodes, np.zeros(0), pairs, pairs, np.zeros(0, int))

    def _compare(self, frame: Frame, *, again: bool) -> bool:
        """Make the picture of the look before the background; whether there is one.

        :param again: this is the second look at the same areas.
        """
        if not again:
            self._reference, self._last = self._last, frame
        reference = self._reference
        if reference is None or reference.image.shape != frame.image.shape:
            return False
        self._detector.learn_background()
        self._detector.detect(reference)
        return True

    def _is_learning(self, stamp: int) -> bool:
        """Whether the background is new: then it needs every picture."""
        if self._learning_until is None:
            self._learning_until = stamp + round(self._config.learn_seconds * NANOSECONDS)
        return self._looks < LEAST_LEARNED or stamp < self._learning_until

    def _segment(self, frame: Frame, outlines: Floats, worn: NDArray[np.bool_]) -> Areas:
        """The areas that are wholly in the picture and of no target, or of a worn one."""
        rows = self._detector.detect(frame).rows
        mask, (height, width) = self._detector.mask, frame.image.shape[:2]
        if rows['area'].sum() > MAX_FOREGROUND * width * height:
            return self._none()
        shapes = outlines.astype(np.float32)
        outline, center, target = [], [], []
        for row in rows:
            u, v, w, h = (int(row[f'box_{name}']) for name in 'uvwh')
            place = float(row['u']), float(row['v'])
            whole = u > 0 and v > 0 and u + w < width and v + h < height
            owners = [i for i, s in enumerate(shapes) if cv2.pointPolygonTest(s, place, False) >= 0]
            if not whole or len(owners) > 1 or not all(worn[i] for i in owners):
                continue
            outline.append(self._outline_of(mask, (u, v, w, h)))
            center.append(place)
            target.append(owners[0] if owners else -1)
        if not target:
            return self._none()
        nodes = np.array([equally_spaced(points, self._spline) for points in outline])
        each = np.empty(len(target), object)
        each[:] = outline
        still = np.zeros((len(target), 2))
        areas = Areas(each, nodes, np.zeros(len(target)), np.array(center), still, np.array(target))
        return areas.take(self._have_edges(frame, nodes))

    def _outline_of(self, mask: NDArray[np.uint8], box: tuple[int, int, int, int]) -> Floats:
        """The outline of the area in a box of a mask, or as in Figure 2 of the box, (P, 2) [px]."""
        u, v, w, h = box
        if self._config.outline == 'box':
            right, bottom = u + w - 1, v + h - 1
            return np.array([(u, v), (right, v), (right, bottom), (u, bottom)], float)
        part = np.ascontiguousarray(mask[v : v + h, u : u + w])
        found, _ = cv2.findContours(part, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        return np.asarray(max(found, key=len)[:, 0] + np.array([u, v], float))

    def _refined(self, areas: Areas) -> Areas:
        """The same with the nodes where a curve follows the outlines best."""
        if self._config.outline == 'box' or not len(areas):
            return areas
        placed = [along_outline(points, self._spline) for points in areas.outline]
        nodes, misfit = (np.array(part) for part in zip(*placed, strict=True))
        return replace(areas, nodes=nodes, misfit=misfit)

    def _have_edges(self, frame: Frame, nodes: Floats) -> NDArray[np.bool_]:
        """Which areas have edges, (K,); where something has been before, there are none."""
        normals, config = self._spline.normals(nodes), self._config
        sigma, usual = np.full(nodes.shape[:2], config.sigma), np.full(nodes.shape, np.nan)
        edges = find_edges(frame.image, nodes, normals, sigma, usual, config)
        return np.asarray(edges.found.mean(axis=1) >= config.start_found)


def _matched(before: Areas, areas: Areas, seconds: float) -> Areas:
    """Areas that are each other's nearest in two pictures, with their velocities."""
    if not len(areas):
        return areas
    gap = np.linalg.norm(areas.center[:, None] - before.center, axis=2)
    nearest = gap.argmin(axis=1)
    mutual = gap.argmin(axis=0)[nearest] == np.arange(len(gap))
    velocity = (areas.center - before.center[nearest]) / seconds
    return replace(areas, velocity=velocity).take(mutual)
