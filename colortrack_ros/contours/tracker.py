"""The contour tracker: a frame in, tracks out."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.filters import Bools
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.filters import Floats
from colortrack_ros.contours.gating import gate
from colortrack_ros.contours.initiation import Areas
from colortrack_ros.contours.initiation import Initiation
from colortrack_ros.contours.lines import find_edges
from colortrack_ros.contours.position import positions
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import Frame
from colortrack_ros.data import Tracks
from colortrack_ros.encodings import plain
from colortrack_ros.estimation.clock import Clock
from colortrack_ros.estimation.track_table import is_inside
from colortrack_ros.estimation.track_table import TrackTable

FIELDS = [('edge_share', 'f4'), ('placed_area', 'f8'), ('misfit', 'f8')]
"""What is recorded of a target besides what is of every track.

edge_share: share of its lines that had an edge when it was last measured; placed_area: when its
nodes were placed [px]; misfit: what the curve missed of its outline then [root of that area].
"""

CONFIRM_HITS = 3
"""Measurements that confirm a target, as many as the tracker of detections wants by default."""

CORRELATED_MISFIT = 0.35
"""Share of what a curve misses of an outline that does not cancel out from node to node. It sets
the covariance alone: half, once and twice the value make the normalized squared error, 2 when
right, 0.89, 0.62, 0.28 on `silhouette` and 1.24, 1.06, 0.72 on `approach`
(``benchmark/contours.py --constants tracker.CORRELATED_MISFIT``)."""

SIDES_SHARE = 0.1
"""Share of each measurement in what is usual beside an edge. Half and twice the value change
nothing on `silhouette` and `approach` (``benchmark/contours.py --constants
tracker.SIDES_SHARE``)."""

GATE_SIGMA = 0.5
"""Standard deviation of a node [px] beyond which edges have to agree with each other all the same:
after a time unseen everything would be as predicted."""

RENEWAL_SCALE = 1.6
"""A contour whose area has become so many times larger or smaller gets new nodes. At twice the
value the mean squared error on `silhouette` is 0.032 instead of 0.037 px^2, on `approach` 0.016
instead of 0.025; at half of it, always renewing, 0.042 and 0.033 (``benchmark/contours.py
--constants tracker.RENEWAL_SCALE``)."""

SAME_TARGET = 0.3
"""What area and position of an area differ by at most if it is that of a target, relatively."""

LEAST_AREA = 16.0
"""A target whose contour encloses less has collapsed [px]: nothing so small starts, see
min_area."""


class ContourTracker:
    """Follows what has moved by its contour, whatever its shape (De Bem 2007).

    :param config: see ContourConfig.
    """

    def __init__(self, config: ContourConfig | None = None) -> None:
        self.config = config or ContourConfig()
        self._initiation, self._clock = Initiation(self.config), Clock()
        self._start(1)

    def _start(self, first_id: int) -> None:
        n = self.config.points
        self._spline = Spline(n, interpolating=self.config.interpolating)
        none = Contours.new(np.zeros((0, n, 2)), np.zeros((0, 2)), self.config)
        self._tracks = TrackTable(none, FIELDS, first_id)

    def reset(self, why: str = '') -> None:
        """Forget all targets, but not the background. IDs go on: none is used twice.

        :param why: told with the next tracks.
        """
        self._clock.restart(why)
        self._initiation.restart()
        self._start(self._tracks.next_id)

    def learn_background(self) -> None:
        """Forget the background: what stands still from the next frame on is background."""
        self._initiation.learn_background()

    def configure(self, config: ContourConfig) -> None:
        """Change the configuration; the targets live on, unless their nodes do not."""
        old, self.config = self.config, config
        self._initiation.configure(config)
        if (old.points, old.interpolating) != (config.points, config.interpolating):
            self._clock.restarted = 'points or interpolating were set'
            self._start(self._tracks.next_id)

    def update(self, frame: Frame) -> Tracks:
        """Take the next frame.

        :return: the tracks at its stamp, with its header.
        """
        frame = plain(frame)
        dt = self._clock.advance(frame.stamp, self.config.max_dt, self.reset)
        frames = dt * self.config.rate
        self._tracks.filters.predict(frames, self.config)
        self._correct(frame, frames)
        self._delete(frame)
        if self._initiation.is_time(self._clock.now):
            outlines = self._spline.outline(self._tracks.filters.nodes)
            new, again = self._initiation.search(frame, outlines, self._outgrown())
            self._renew(frame, again)
            self._initiate(frame, new)
        outlines, why = self._spline.outline(self._tracks.filters.nodes), self._clock.tell_restart()
        return Tracks(self._rows(outlines), frame.stamp, frame.frame_id, why, outlines)

    def _correct(self, frame: Frame, frames: float) -> None:
        """Update filters and records with the edges of the frame."""
        contours, records = self._tracks.filters, self._tracks.records
        measured, share = self._measure(frame, contours, frames, self.config.min_found)
        records['edge_share'][measured] = share[measured]
        self._tracks.record_hits(measured, self._clock.now)
        contours.hold_size(~measured)

    def _measure(
        self, frame: Frame, contours: Contours, frames: float, least: float
    ) -> tuple[Bools, Floats]:
        """Correct contours by the edges on their lines, and learn what is beside the edges.

        :param frames: time passed.
        :param least: share of the lines that need an edge.
        :return: whether there were enough, and their share, (N,).
        """
        if not len(contours):
            return np.zeros(0, bool), np.zeros(0)
        config, usual = self.config, contours.sides
        normals = self._spline.normals(contours.nodes)
        spread = contours.sigma_along(normals)
        sigma = np.hypot(config.sigma, spread)
        edges = find_edges(frame.image, contours.nodes, normals, sigma, usual, config)
        spread = np.hypot(np.minimum(spread, GATE_SIGMA), config.edge_variance**0.5)
        good = gate(edges.offset, edges.found, spread, normals, contours.nodes, config)
        share = good.mean(axis=1)
        measured = share >= max(least, 1e-9)
        good &= measured[:, None]
        contours.correct(edges.offset, good, normals, frames, config)
        before, now = usual[good], edges.sides[good]
        usual[good] = np.where(np.isnan(before), now, before + SIDES_SHARE * (now - before))
        return np.asarray(measured), np.asarray(share)

    def _delete(self, frame: Frame) -> None:
        """Delete targets that have left the picture, were not seen for long, or have collapsed.

        A tentative one has to be seen in every frame.
        """
        tracks, nodes, now = self._tracks, self._tracks.filters.nodes, self._clock.now
        tentative = tracks.update_states(now, CONFIRM_HITS)
        lost = tracks.is_overdue(now, self.config.max_time_since_update)
        lost |= tentative & tracks.is_overdue(now, 0.0)
        keep = is_inside(nodes.mean(axis=1), *frame.image.shape[:2]) & ~lost
        keep &= self._spline.area(nodes) >= LEAST_AREA
        if not keep.all():
            tracks.keep(keep)

    def _initiate(self, frame: Frame, new: Areas) -> None:
        """Begin what was found by its motion and has the edges of a contour."""
        free = self.config.max_targets - len(self._tracks)
        new = new.take(np.arange(len(new)) < free)
        if not len(new):
            return
        contours = Contours.new(new.nodes, new.velocity / self.config.rate, self.config)
        area, good = self._fitted(frame, contours)
        records = self._tracks.initiate(contours.take(good), self._clock.now)
        records['edge_share'] = 1
        records['placed_area'] = np.maximum(area[good], 1.0)
        records['misfit'] = new.misfit[good] / np.sqrt(records['placed_area'])

    def _fitted(self, frame: Frame, contours: Contours) -> tuple[Floats, Bools]:
        """Measure contours for the first time; return their areas, and which are sound, (K,)."""
        good, _ = self._measure(frame, contours, 0.0, self.config.start_found)
        area = self._spline.area(contours.nodes)
        return area, good & (area >= LEAST_AREA)

    def _outgrown(self) -> Bools:
        """The target whose size has changed most, if by much; one, as placing nodes takes time."""
        records = self._tracks.records
        area = np.maximum(self._spline.area(self._tracks.filters.nodes), 1.0)
        log_growth = np.abs(np.log(area / records['placed_area']))
        log_growth[records['updated'] < self._clock.now] = 0.0
        most = max(log_growth.max(initial=0.0), np.log(RENEWAL_SCALE))
        return np.asarray(log_growth >= most)

    def _renew(self, frame: Frame, areas: Areas) -> None:
        """Give targets whose size has changed much new nodes, on outlines that are theirs still."""
        if not len(areas):
            return
        area, own = self._spline.area(areas.nodes), self._tracks.filters
        old = self._spline.area(own.nodes)[areas.target]
        center = self._spline.centroid(own.nodes)[0][areas.target]
        away = np.linalg.norm(areas.center - center, axis=1)
        with np.errstate(divide='ignore', invalid='ignore'):
            same = (np.abs(np.log(area / old)) < SAME_TARGET) & (away < SAME_TARGET * np.sqrt(old))
        areas = areas.take(same)
        contours = own.renewed(areas.target, areas.nodes, self.config)
        area, good = self._fitted(frame, contours)
        track, area, records = areas.target[good], np.maximum(area[good], 1.0), self._tracks.records
        own.put(track, contours.take(good))
        records['placed_area'][track] = area
        records['misfit'][track] = areas.misfit[good] / area**0.5

    def _rows(self, outlines: Floats) -> NDArray[np.void]:
        """The tracks as they are published; the outlines are (N, P, 2) [px]."""
        tracks, contours, now = self._tracks, self._tracks.filters, self._clock.now
        area = self._spline.area(contours.nodes)
        misfit = (CORRELATED_MISFIT * tracks.records['misfit']) ** 2 * np.maximum(area, 0.0)
        rows = tracks.rows(now, *positions(contours, self._spline, self.config.rate, misfit))
        rows['area'] = area
        rows['box_w'], rows['box_h'] = np.ptp(outlines, axis=1).T
        fresh = tracks.freshness(now, self.config.max_time_since_update)
        rows['score'] = np.clip(tracks.records['edge_share'], 0, 1) * fresh
        return rows
