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
from colortrack_ros.contours.start import Start
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

LEARNING = 0.1
"""Share of each measurement in what is usual beside an edge."""

LOOSEST = 0.5
"""Standard deviation of a node [px] beyond which edges have to agree with each other all the same:
after a time unseen everything would be as expected."""

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
        """Forget all targets and the background. IDs go on: none is used twice.

        :param why: told with the next tracks.
        """
        self._why = why
        self._stamp: int | None = None
        self._start.restart()
        self._clear()

    def _clear(self) -> None:
        n = self.config.points
        self._spline = Spline(n, interpolating=self.config.interpolating)
        self._contours = Contours.new(np.zeros((0, n, 2)), np.zeros((0, 2)), self.config)
        self._usual = np.zeros((0, n, 2))
        self._records = np.zeros(0, RECORD)

    def configure(self, config: ContourConfig) -> None:
        """Change the configuration; the targets live on, unless it is other nodes that they have."""
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
        measured = self._measure(frame, self._contours, self._usual, T)
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
        dt = 0.0 if self._stamp is None else (stamp - self._stamp) / NANOSECONDS
        if dt < 0:
            self.reset(f'the stamp went back by {-dt:.6f} s')
        elif dt > self.config.max_dt:
            self.reset(f'the stamp jumped ahead by {dt:.6f} s, max_dt is {self.config.max_dt:g} s')
        T = 0.0 if self._stamp is None else dt * self.config.rate
        self._stamp = stamp
        self._contours.predict(T, self.config)
        return T

    def _measure(self, frame: Frame, contours: Contours, usual: Floats, T: float) -> Bools:
        """Correct contours by the edges on their lines; whether there were enough, (N,)."""
        if not len(contours):
            return np.zeros(0, bool)
        config = self.config
        normals = self._spline.normals(contours.nodes)
        spread = contours.deviations(normals)
        sigma = np.hypot(config.sigma, spread)
        edges = find_edges(frame.image, contours.nodes, normals, sigma, usual, config)
        spread = np.hypot(np.minimum(spread, LOOSEST), config.edge_variance**0.5)
        good = agree(edges.offset, edges.found, spread, normals, contours.nodes, config)
        share = good.mean(axis=1)
        measured = share >= max(config.min_found, 1e-9)
        good &= measured[:, None]
        contours.correct(edges.offset, good, normals, T, config)
        step = np.where(np.isnan(usual), 1.0, LEARNING)
        known = np.where(np.isnan(usual), edges.sides, usual)
        usual[good] = (known + step * (edges.sides - known))[good]
        if contours is self._contours:
            self._records['found'][measured] = share[measured]
        return np.asarray(measured)

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
        new = self._start.search(frame, self._spline.outline(self._contours.nodes))
        room = max(self.config.max_targets - len(self._records), 0)
        if not min(len(new.nodes), room):
            return
        velocity = new.velocity[:room] / self.config.rate
        contours = Contours.new(new.nodes[:room], velocity, self.config)
        usual = np.full(contours.nodes.shape, np.nan)
        good = self._measure(frame, contours, usual, 0.0)
        self._contours = self._contours.joined(contours.keep(good))
        self._usual = np.concatenate([self._usual, usual[good]])
        miss = new.miss[:room] / np.sqrt(np.maximum(self._spline.area(contours.nodes), 1.0))
        records = births(miss[good], self._now, self._next_id)
        self._next_id += len(records)
        self._records = np.concatenate([self._records, records])

    @property
    def _now(self) -> int:
        return self._stamp or 0
