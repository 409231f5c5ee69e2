"""The contour tracker: a frame in, tracks out."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.filters import agree
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.life import births
from colortrack_ros.contours.life import CONFIRMING
from colortrack_ros.contours.life import RECORD
from colortrack_ros.contours.life import rows
from colortrack_ros.contours.lines import find_edges
from colortrack_ros.contours.spline import Spline
from colortrack_ros.contours.start import Areas
from colortrack_ros.contours.start import Start
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.estimation.clock import time_passed

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

LEARNING = 0.1
"""Share of each measurement in what is usual beside an edge."""

LOOSEST = 0.5
"""Standard deviation of a node [px] beyond which edges have to agree with each other all the same:
after a time unseen everything would be as expected."""

GROWN = 1.6
"""A contour whose area has become so many times larger or smaller gets new nodes."""

ALIKE = 0.3
"""What area and position of an area differ by at most if it is that of a target, relatively."""

LEAST_AREA = 16.0
"""A target whose contour encloses less is none any more [px]."""


class ContourTracker:
    """Follows what has moved by its contour, whatever its shape (De Bem 2007).

    :param config: see ContourConfig.
    """

    def __init__(self, config: ContourConfig | None = None) -> None:
        self.config = config or ContourConfig()
        self._next_id = 1
        self._start = Start(self.config)
        self.reset()
        self._why = ''

    def reset(self, why: str = '') -> None:
        """Forget all targets, but not the background. IDs go on: none is used twice.

        :param why: told with the next tracks.
        """
        self._why = why
        self._stamp: int | None = None
        self._start.restart()
        self._clear()

    def learn_background(self) -> None:
        """Forget the background: what stands still from the next frame on is background."""
        self._start.learn_background()

    def _clear(self) -> None:
        n = self.config.points
        self._spline = Spline(n, interpolating=self.config.interpolating)
        self._contours = Contours.new(np.zeros((0, n, 2)), np.zeros((0, 2)), self.config)
        self._usual = np.zeros((0, n, 2))
        self._records = np.zeros(0, RECORD)

    def configure(self, config: ContourConfig) -> None:
        """Change the configuration; the targets live on, unless their nodes do not."""
        old, self.config = self.config, config
        self._start.configure(config)
        if (old.points, old.interpolating) != (config.points, config.interpolating):
            self._why = 'points or interpolating were set'
            self._clear()

    def update(self, frame: Frame) -> Tracks:
        """Take the next frame.

        :return: the tracks at its stamp, with its header.
        """
        T = self._advance(frame.stamp)
        measured, share = self._measure(
            frame, self._contours, self._usual, T, self.config.min_found
        )
        self._records['found'][measured] = share[measured]
        self._records['updated'][measured] = self._now
        self._records['hits'][measured] += 1
        self._contours.rest(~measured)
        self._settle(frame)
        self._begin(frame)
        why, self._why = self._why, ''
        patience = self.config.max_time_since_update
        tracks, outlines = rows(
            self._records, self._contours, self._spline, self.config.rate, self._now, patience
        )
        return Tracks(tracks, frame.stamp, frame.frame_id, why, outlines)

    def _advance(self, stamp: int) -> float:
        """Predict to the stamp, or start afresh; return the time passed [frames]."""
        dt, why = time_passed(self._stamp, stamp, self.config.max_dt)
        if why:
            self.reset(why)
        T = dt * self.config.rate
        self._stamp = stamp
        self._contours.predict(T, self.config)
        return T

    def _measure(
        self, frame: Frame, contours: Contours, usual: Floats, T: float, least: float
    ) -> tuple[Bools, Floats]:
        """Correct contours by the edges on their lines.

        :param usual: (N, n, 2) what is beside the edges [levels], NaN where unknown; learned.
        :param T: time passed [frames].
        :param least: share of the lines that need an edge.
        :return: whether there were enough, and their share, (N,).
        """
        if not len(contours):
            return np.zeros(0, bool), np.zeros(0)
        config = self.config
        normals = self._spline.normals(contours.nodes)
        spread = contours.deviations(normals)
        sigma = np.hypot(config.sigma, spread)
        edges = find_edges(frame.image, contours.nodes, normals, sigma, usual, config)
        spread = np.hypot(np.minimum(spread, LOOSEST), config.edge_variance**0.5)
        good = agree(edges.offset, edges.found, spread, normals, contours.nodes, config)
        share = good.mean(axis=1)
        measured = share >= max(least, 1e-9)
        good &= measured[:, None]
        contours.correct(edges.offset, good, normals, T, config)
        before, now = usual[good], edges.sides[good]
        usual[good] = np.where(np.isnan(before), now, before + LEARNING * (now - before))
        return np.asarray(measured), np.asarray(share)

    def _settle(self, frame: Frame) -> None:
        """Give up targets that have left the picture, were not seen for long, or have collapsed."""
        if not len(self._records):
            return
        center, (height, width) = self._contours.nodes.mean(axis=1), frame.image.shape[:2]
        inside = ((center >= -0.5) & (center < [width - 0.5, height - 0.5])).all(axis=1)
        whole = self._spline.area(self._contours.nodes) >= LEAST_AREA
        limit = np.where(
            self._records['hits'] < CONFIRMING,
            0,
            round(self.config.max_time_since_update * NANOSECONDS),
        )
        self._keep(inside & whole & (self._now - self._records['updated'] <= limit))

    def _keep(self, mask: Bools) -> None:
        if not mask.all():
            self._contours = self._contours.keep(mask)
            self._records, self._usual = self._records[mask], self._usual[mask]

    def _begin(self, frame: Frame) -> None:
        """Start what is found by its motion and has the edges of a contour."""
        if not self._start.is_time(self._now):
            return
        outlines = self._spline.outline(self._contours.nodes)
        new, again = self._start.search(frame, outlines, self._worn())
        if len(again):
            self._renew(frame, again)
        new = new.take(np.arange(len(new)) < self.config.max_targets - len(self._records))
        if not len(new):
            return
        contours = Contours.new(new.nodes, new.velocity / self.config.rate, self.config)
        usual = np.full(contours.nodes.shape, np.nan)
        good, _ = self._measure(frame, contours, usual, 0.0, self.config.start_found)
        good &= self._spline.area(contours.nodes) >= LEAST_AREA
        self._contours = self._contours.joined(contours.keep(good))
        self._usual = np.concatenate([self._usual, usual[good]])
        area = self._spline.area(contours.nodes)[good]
        records = births(new.miss[good], area, self._now, self._next_id)
        self._next_id += len(records)
        self._records = np.concatenate([self._records, records])

    def _worn(self) -> Bools:
        """The target whose size has changed most, if by much; one, as placing nodes takes time."""
        area = np.maximum(self._spline.area(self._contours.nodes), 1.0)
        grown = np.abs(np.log(area / self._records['placed']))
        grown[self._records['updated'] < self._now] = 0.0
        most = max(grown.max(initial=0.0), np.log(GROWN))
        return np.asarray(grown >= most)

    def _renew(self, frame: Frame, areas: Areas) -> None:
        """Give targets whose size has changed much new nodes, on outlines that are theirs still."""
        area = self._spline.area(areas.nodes)
        old = self._spline.area(self._contours.nodes)[areas.of]
        center = self._spline.centroid(self._contours.nodes)[0][areas.of]
        far = np.linalg.norm(areas.center - center, axis=1)
        with np.errstate(divide='ignore', invalid='ignore'):
            same = (np.abs(np.log(area / old)) < ALIKE) & (far < ALIKE * np.sqrt(old))
        areas = areas.take(same)
        contours = self._contours.renewed(areas.of, areas.nodes, self.config)
        usual = np.full(contours.nodes.shape, np.nan)
        good, _ = self._measure(frame, contours, usual, 0.0, self.config.start_found)
        good &= self._spline.area(contours.nodes) >= LEAST_AREA
        of = areas.of[good]
        self._contours.put(of, contours.keep(good))
        self._usual[of] = usual[good]
        area = np.maximum(self._spline.area(contours.nodes)[good], 1.0)
        self._records['placed'][of], self._records['miss'][of] = area, areas.miss[good] / area**0.5

    @property
    def _now(self) -> int:
        return self._stamp or 0
