"""The contour tracker: a frame in, tracks out."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.agreement import believed
from colortrack_ros.contours.agreement import expected_boxes
from colortrack_ros.contours.agreement import follow
from colortrack_ros.contours.areas import Areas
from colortrack_ros.contours.boxes import boxes
from colortrack_ros.contours.boxes import is_at_border
from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.filters import Bools
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.filters import Floats
from colortrack_ros.contours.foreground import Foreground
from colortrack_ros.contours.gating import gate
from colortrack_ros.contours.initiation import Initiation
from colortrack_ros.contours.lines import find_edges
from colortrack_ros.contours.placing import along_outline
from colortrack_ros.contours.placing import equally_spaced
from colortrack_ros.contours.position import positions
from colortrack_ros.contours.records import CONTOUR_FIELDS
from colortrack_ros.contours.records import hold_unmoved
from colortrack_ros.contours.regions import is_double
from colortrack_ros.contours.regions import is_same
from colortrack_ros.contours.regions import is_within
from colortrack_ros.contours.regions import match
from colortrack_ros.contours.regions import OwnAreas
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import Tracks
from colortrack_ros.encodings import plain
from colortrack_ros.estimation.clock import Clock
from colortrack_ros.estimation.track_table import is_inside
from colortrack_ros.estimation.track_table import TrackTable

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

LEAST_AREA = 16.0
"""A target whose contour encloses less has collapsed [px]: nothing so small starts (min_area)."""


class ContourTracker:
    """Follows what has moved by its contour, whatever its shape (De Bem 2007).

    :param config: see ContourConfig.
    """

    def __init__(self, config: ContourConfig | None = None) -> None:
        self.config = config or ContourConfig()
        self._foreground, self._initiation = Foreground(self.config), Initiation()
        self._clock = Clock()
        self._start(1)

    def _start(self, first_id: int) -> None:
        n = self.config.points
        self._spline = Spline(n, interpolating=self.config.interpolating)
        none = Contours.new(np.zeros((0, n, 2)), np.zeros((0, 2)), self.config)
        self._tracks = TrackTable(none, CONTOUR_FIELDS, first_id)

    def reset(self, why: str = '') -> None:
        """Forget all targets, but not the background. IDs go on: none is used twice.

        :param why: told with the next tracks.
        """
        self._clock.restart(why)
        self._initiation.restart()
        self._foreground.restart()
        self._start(self._tracks.next_id)

    def learn_background(self) -> None:
        """Forget the background: what stands still from the next frame on is background."""
        self._foreground.learn_background()
        self._initiation.restart()

    def configure(self, config: ContourConfig) -> None:
        """Change the configuration; the targets live on, unless their nodes do not."""
        old, self.config = self.config, config
        self._foreground.configure(config)
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
        unseen = self._tracks.unmeasured(self._clock.now) - dt
        predicted = expected_boxes(self._tracks.filters, self._spline, unseen)
        areas = self._foreground.areas(frame, predicted[self._is_known()])
        if areas is None:
            self._tracks.keep(self._is_known())  # what is new may be background that moves
            self._correct(frame, frames)
            self._delete(frame)
        else:
            regions, nobodys = match(predicted, areas)
            single = ~is_double(predicted, regions, self._tracks.records['inner'])
            if not single.all():
                self._tracks.keep(single)
                regions, nobodys = match(predicted[single], areas)
            follows = self.config.follow_foreground
            self._correct(frame, frames, regions if follows else None)
            self._place_anew(frame, areas, regions)
            self._delete(frame)
            self._initiate(areas.take(nobodys & (follows | ~areas.cut.any(axis=1))), predicted)
            outlines = self._spline.outline(self._tracks.filters.nodes[self._is_known()])
            self._foreground.learn_clutter(boxes(outlines), dt)
        rows, outlines = self._published()
        return Tracks(rows, frame.stamp, frame.frame_id, self._clock.tell_restart(), outlines)

    def _is_known(self) -> Bools:
        return np.asarray(self._tracks.records['state'] != TENTATIVE)

    def _correct(self, frame: Frame, frames: float, regions: OwnAreas | None = None) -> None:
        """Update filters and records with the edges of the frame where the foreground agrees.

        Elsewhere with the foreground; nothing is there where there is none. Without regions the
        edges are believed.
        """
        contours, records, now = self._tracks.filters, self._tracks.records, self._clock.now
        predicted = contours.take(np.arange(len(contours)))
        measured, share = self._measure(frame, contours, frames, self.config.min_found)
        records['edge_share'][measured] = share[measured]
        if regions is not None and len(contours):
            before, after = (boxes(self._spline.outline(c.nodes)) for c in (predicted, contours))
            longest = round(self.config.max_time_since_update * NANOSECONDS)
            recent = now - records['agreed'] <= longest
            rigid = ~records['by_area']
            clear = share >= self.config.start_found
            good = measured & believed(before, after, regions, recent, rigid, clear)
            found = regions.first >= 0
            if self.config.start == 'difference':  # that does not see what stands still
                good |= measured & ~found
            wrong = np.flatnonzero(~good)
            contours.put(wrong, predicted.take(wrong))
            wrong = wrong[found[wrong]]
            part = contours.take(wrong)
            own = regions.take(wrong), recent[wrong], rigid[wrong]
            follow(part, *own, frames, self._spline, self.config)
            contours.put(wrong, part)
            records['by_area'] |= ~good & found & ~(rigid & recent)
            records['edge_share'][wrong] = 1.0
            measured = good | found
            records['agreed'][~measured] += round(frames / self.config.rate * NANOSECONDS)
        self._tracks.record_hits(measured, now)
        contours.hold_size(~measured)

    def _place_anew(self, frame: Frame, areas: Areas, regions: OwnAreas) -> None:
        """Give targets that follow their areas, or have outgrown their nodes, new nodes.

        Along the outlines, for one of them where the curve follows it best: that takes time.
        """
        records, contours = self._tracks.records, self._tracks.filters
        same = is_same(boxes(self._spline.outline(contours.nodes)), regions)
        records['agreed'][same] = self._clock.now
        for i in np.flatnonzero(same & records['by_area']).tolist():
            contours.nodes[i] = equally_spaced(self._outline(areas, regions.first[i]), self._spline)
        wants = same & ~regions.cut.any(axis=1) & (records['by_area'] | self._outgrown())
        if not wants.any():
            return
        which = np.flatnonzero(wants)
        which = which[[np.argmin(records['placed'][which])]]
        records['placed'][which] = self._clock.now
        nodes, misfit = along_outline(self._outline(areas, regions.first[which[0]]), self._spline)
        new = contours.renewed(which, nodes[None], self.config)
        area, good = self._fitted(frame, new)
        if good.all():
            contours.put(which, new)
            records['by_area'][which] = False
            records['placed_area'][which] = area = np.maximum(area, 1.0)
            records['misfit'][which] = misfit / area**0.5

    def _outline(self, areas: Areas, k: int) -> Floats:
        """Where the first nodes lie: on an area's outline, or as in Figure 2 on its box."""
        if self.config.outline == 'area':
            return areas.outline(k)
        return areas.box[k][[[0, 1], [2, 1], [2, 3], [0, 3]]]

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
        speed = self.config.rate * np.hypot(*tracks.filters.motion[:, :2].T)
        tentative |= hold_unmoved(tracks.records, nodes, speed, self.config.min_motion, now)
        lost = tracks.is_overdue(now, self.config.max_time_since_update)
        lost |= tentative & tracks.is_overdue(now, 0.0)
        keep = is_inside(nodes.mean(axis=1), *frame.image.shape[:2]) & ~lost
        keep &= self._spline.area(nodes) >= LEAST_AREA
        leaves = is_at_border(boxes(self._spline.outline(nodes)), *frame.image.shape[:2])
        keep &= ~leaves | (tracks.records['updated'] == now)
        if not keep.all():
            tracks.keep(keep)

    def _initiate(self, nobodys: Areas, predicted: Floats) -> None:
        """Begin what is nobody's in two frames, on its outline.

        :param predicted: boxes of the other targets.
        """
        new = self._initiation.candidates(nobodys, self._clock.now)
        free = self.config.max_targets - len(self._tracks)
        new = new.take(np.arange(len(new)) < free)
        if not len(new):
            return
        spline = self._spline
        outlines = [self._outline(new.areas, k) for k in range(len(new))]
        nodes = [equally_spaced(points, spline) for points in outlines]
        contours = Contours.new(np.array(nodes), new.velocity / self.config.rate, self.config)
        records = self._tracks.initiate(contours, self._clock.now)
        records['edge_share'], records['by_area'] = 1.0, self.config.outline == 'area'
        records['inner'] = is_within(new.areas.box, predicted)
        records['agreed'] = records['from'] = self._clock.now
        records['placed_area'] = np.maximum(spline.area(contours.nodes), 1.0)
        records['from_u'], records['from_v'] = contours.nodes.mean(axis=1).T

    def _fitted(self, frame: Frame, contours: Contours) -> tuple[Floats, Bools]:
        """Measure contours for the first time; return their areas, and which are sound, (K,)."""
        good, _ = self._measure(frame, contours, 0.0, self.config.start_found)
        area = self._spline.area(contours.nodes)
        return area, good & (area >= LEAST_AREA)

    def _outgrown(self) -> Bools:
        """The targets whose size has changed by much."""
        area = np.maximum(self._spline.area(self._tracks.filters.nodes), 1.0)
        log_growth = np.abs(np.log(area / self._tracks.records['placed_area']))
        return np.asarray(log_growth >= np.log(RENEWAL_SCALE))

    def _published(self) -> tuple[NDArray[np.void], Floats]:
        """Rows and outlines of all but confirmed tracks that probably do not exist any more."""
        tracks = self._tracks
        fresh = tracks.freshness(self._clock.now, self.config.max_time_since_update)
        score = np.clip(tracks.records['edge_share'], 0, 1) * fresh
        shown = (score >= self.config.min_score) | ~self._is_known()
        tracks, score = tracks.take(shown), score[shown]
        contours, now = tracks.filters, self._clock.now
        area, outlines = self._spline.area(contours.nodes), self._spline.outline(contours.nodes)
        misfit = (CORRELATED_MISFIT * tracks.records['misfit']) ** 2 * np.maximum(area, 0.0)
        rows = tracks.rows(now, *positions(contours, self._spline, self.config.rate, misfit))
        rows['area'], rows['score'] = area, score
        rows['box_w'], rows['box_h'] = np.ptp(outlines, axis=1).T
        return rows, outlines
