"""The contour tracker: a frame in, tracks out."""

import numpy as np
from numpy.typing import ArrayLike

from colortrack_ros.contours.agreement import believed
from colortrack_ros.contours.agreement import expected_boxes
from colortrack_ros.contours.agreement import follow
from colortrack_ros.contours.agreement import history
from colortrack_ros.contours.areas import Areas
from colortrack_ros.contours.boxes import boxes
from colortrack_ros.contours.boxes import is_at_border
from colortrack_ros.contours.changes import remember
from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.deformation import learn_form
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.foreground import Foreground
from colortrack_ros.contours.initiation import Initiation
from colortrack_ros.contours.measurement import measure
from colortrack_ros.contours.placing import along_outline
from colortrack_ros.contours.placing import equally_spaced
from colortrack_ros.contours.publishing import published
from colortrack_ros.contours.records import begin
from colortrack_ros.contours.records import CONTOUR_FIELDS
from colortrack_ros.contours.records import hold_unproven
from colortrack_ros.contours.records import outgrown
from colortrack_ros.contours.regions import is_double
from colortrack_ros.contours.regions import is_hidden
from colortrack_ros.contours.regions import is_same
from colortrack_ros.contours.regions import is_within
from colortrack_ros.contours.regions import match
from colortrack_ros.contours.regions import OwnAreas
from colortrack_ros.contours.reunion import resume
from colortrack_ros.contours.scene_change import OTHER_SCENE
from colortrack_ros.contours.spline import Spline
from colortrack_ros.contours.told import begin_told
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import Tracks
from colortrack_ros.detection.background_model import Picture
from colortrack_ros.detection.pixels import channels_of
from colortrack_ros.encodings import check
from colortrack_ros.encodings import plain
from colortrack_ros.estimation.clock import Clock
from colortrack_ros.estimation.track_table import is_inside
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.estimation.waiting_boxes import WaitingBoxes

CONFIRM_HITS = 3
"""Measurements that confirm a target, as in the tracker of detections by default."""

LEAST_AREA = 16.0
"""A target with a smaller area has collapsed [px]: nothing this small starts (min_area)."""


class ContourTracker:
    """Tracks moving things by their contours, whatever their shape (De Bem 2007).

    :param config: see ContourConfig.
    :param targets: boxes to start in the first frame, and after each restart; see start.
    :ivar waiting: boxes that wait for the next frame.
    :ivar trouble: why nothing new is looked for, empty if it is.
    :ivar scene_changes: number of times that another scene has become the background.
    """

    def __init__(self, config: ContourConfig | None = None, targets: ArrayLike = ()) -> None:
        self.config, self.waiting = config or ContourConfig(), WaitingBoxes(targets)
        self.trouble = ''
        self._foreground, self._initiation = Foreground(self.config), Initiation()
        self._clock, self.scene_changes = Clock(), 0
        self._start(1)

    def _start(self, first_id: int) -> None:
        n = self.config.points
        self._spline = Spline(n, interpolating=self.config.interpolating)
        none = Contours.new(np.zeros((0, n, 2)), np.zeros((0, 2)), self.config)
        self._tracks = TrackTable(none, CONTOUR_FIELDS, first_id)

    def reset(self, why: str = '') -> None:
        """Forget all targets, but not the background; IDs go on. The next tracks tell why."""
        self._clock.restart(why)
        self._initiation.restart()
        self._foreground.restart()
        self.waiting.restart()
        self._start(self._tracks.next_id)

    def learn_background(self) -> None:
        """Forget the background, and learn it again from the next frame on."""
        self._foreground.learn_background()
        self._initiation.restart()

    def configure(self, config: ContourConfig) -> None:
        """Change the configuration; targets survive unless their nodes change."""
        old, self.config = self.config, config
        self._foreground.configure(config)
        if (old.points, old.interpolating) != (config.points, config.interpolating):
            self._clock.restarted = 'points or interpolating were set'
            self._start(self._tracks.next_id)

    def start(self, boxes: ArrayLike) -> None:
        """Start targets in boxes, (N, 4), in the next frame; see WaitingBoxes."""
        self.waiting.add(boxes, offered=False)

    def offer(self, boxes: ArrayLike) -> None:
        """Start targets in boxes where there is no target yet."""
        self.waiting.add(boxes, offered=True)

    def update(self, frame: Frame) -> Tracks:
        """Track targets to the next frame.

        A frame older than the last one restarts the tracker; frames that are merely late are
        reordered or dropped, and counted, before they get here (flow.order).

        :raises ValueError: if the encoding is unknown or does not fit the picture's shape.
        :return: the tracks at its stamp, with its header.
        """
        check(frame)
        frame = plain(frame)
        dt = self._clock.advance(frame.stamp, self.config.max_dt, self.reset)
        frames = dt * self.config.rate
        self._tracks.filters.predict(frames, self.config)
        unseen = self._tracks.unmeasured(self._clock.now) - dt
        predicted = expected_boxes(self._tracks.filters, self._spline, unseen)
        areas = self._foreground.areas(frame, predicted[self._is_known()])
        self.trouble = self._foreground.trouble
        if areas is None:
            self._tracks.keep(self._lives_on())
            self._correct(frame, frames)
            self._delete(frame)
        else:
            regions, nobodys = match(predicted, areas)
            single = ~is_double(predicted, regions, self._tracks.records, self._velocity())
            if not single.all():
                self._tracks.keep(single)
                regions, nobodys = match(predicted[single], areas)
            self._correct(frame, frames, regions if self.config.follow_foreground else None)
            self._place_anew(frame, areas, regions)
            self._delete(frame)
            self._initiate(areas.take(nobodys), predicted, channels_of(frame))
            own = boxes(self._spline.outline(self._tracks.filters.nodes))
            self._foreground.learn(own, self._tracks.records, dt)
        begin_told(self._tracks, self.waiting, frame, self._spline, self.config, self._clock.now)
        return self._published(frame, dt)

    def _published(self, frame: Frame, dt: float) -> Tracks:
        tracks, now = self._tracks, self._clock.now
        outlines = self._spline.outline(tracks.filters.nodes)
        learn_form(tracks.records, np.ptp(outlines, axis=1), dt, now)
        foreground = self._foreground
        rows, outlines = published(tracks, outlines, self._spline, self.config, now, foreground)
        return Tracks(rows, frame.stamp, frame.frame_id, self._clock.tell_restart(), outlines)

    def _lives_on(self) -> Bools:
        """Return which targets, (N,), survive while the background is covered."""
        if not self._foreground.is_new:
            return self._is_known()  # new ones may be moving background
        self.scene_changes, self._clock.restarted = self.scene_changes + 1, OTHER_SCENE
        return np.asarray(self._tracks.records['told'])

    def _velocity(self) -> Floats:
        return np.asarray(self.config.rate * self._tracks.filters.motion[:, :2])

    def _is_known(self) -> Bools:
        return np.asarray(self._tracks.records['state'] != TENTATIVE)

    def _correct(self, frame: Frame, frames: float, regions: OwnAreas | None = None) -> None:
        """Update filters and records with edges where the foreground agrees, elsewhere with it.

        Without foreground there is no target. Without regions, all edges are believed.
        """
        contours, records, now = self._tracks.filters, self._tracks.records, self._clock.now
        seconds = frames / self.config.rate
        predicted = contours.take(np.arange(len(contours)))
        least = self.config.min_found
        measured, share = measure(frame, contours, self._spline, frames, least, self.config)
        records['edge_share'][measured] = share[measured]
        if regions is not None and len(contours):
            before, after = (boxes(self._spline.outline(c.nodes)) for c in (predicted, contours))
            longest = self.config.max_time_since_update
            past = history(records, before, regions, now, longest, seconds)
            hidden, clear = is_hidden(before, regions), share >= self.config.start_found
            found = (regions.first >= 0) & ~hidden
            good = measured & ~hidden & believed(before, after, regions, past, clear)
            stands = (regions.first < 0) & (self.config.start == 'difference')
            good |= measured & (stands | records['told'])
            wrong = np.flatnonzero(~good)
            contours.put(wrong, predicted.take(wrong))
            contours.hold_size(~good)
            wrong = wrong[found[wrong]]
            part, own = contours.take(wrong), (regions.take(wrong), past.take(wrong))
            follow(part, *own, frames, self._spline, self.config)
            contours.put(wrong, part)
            records['by_area'] |= ~good & found & ~(past.rigid & past.recent)
            records['edge_share'][wrong] = 1.0
            measured = good | found
            records['agreed'][~measured] += round(seconds * NANOSECONDS)
        self._tracks.record_hits(measured, now)
        contours.hold_size(~measured)

    def _place_anew(self, frame: Frame, areas: Areas, regions: OwnAreas) -> None:
        """Place new nodes on targets that follow their areas, or have outgrown their nodes.

        They are equally spaced on the outlines. For one target a frame, they are also optimized,
        which takes time, once the background is learned.
        """
        records, contours, kind = self._tracks.records, self._tracks.filters, self.config.outline
        same = is_same(boxes(self._spline.outline(contours.nodes)), regions)
        records['agreed'][same] = self._clock.now
        for i in np.flatnonzero(same & records['by_area']).tolist():
            outline = areas.outline(regions.first[i], kind)
            contours.nodes[i] = equally_spaced(outline, self._spline)
        wants = same & ~regions.cut.any(axis=1)
        wants &= records['by_area'] | outgrown(records, self._spline.area(contours.nodes))
        if not wants.any() or self._foreground.is_learning or self._foreground.is_busy:
            return
        which = np.flatnonzero(wants)
        which = which[[np.argmin(records['placed'][which])]]
        records['placed'][which] = self._clock.now
        outline = areas.outline(regions.first[which[0]], kind)
        nodes, misfit = along_outline(outline, self._spline)
        new = contours.renewed(which, nodes[None], self.config)
        least = self.config.start_found
        good, _ = measure(frame, new, self._spline, 0.0, least, self.config)
        area = self._spline.area(new.nodes)
        if (good & (area >= LEAST_AREA)).all():
            contours.put(which, new)
            records['by_area'][which] = False
            records['placed_area'][which] = area = np.maximum(area, 1.0)
            records['misfit'][which] = misfit / area**0.5

    def _delete(self, frame: Frame) -> None:
        """Delete targets that have left the picture, are overdue, or have collapsed.

        A tentative one has to be seen in every frame.
        """
        tracks, nodes, now = self._tracks, self._tracks.filters.nodes, self._clock.now
        tentative = tracks.update_states(now, CONFIRM_HITS)
        speed = self.config.rate * np.hypot(*tracks.filters.motion[:, :2].T)
        area = self._spline.area(nodes)
        size = frame.image.shape[:2]
        picture = channels_of(frame)
        tentative |= hold_unproven(tracks.records, nodes, area, speed, self.config, picture, now)
        lost = tracks.is_overdue(now, self.config.max_time_since_update)
        lost |= tentative & tracks.is_overdue(now, 0.0)
        keep = is_inside(nodes.mean(axis=1), *size) & ~lost & (area >= LEAST_AREA)
        leaves = is_at_border(boxes(self._spline.outline(nodes)), *size)
        keep &= ~leaves | (tracks.records['updated'] == now)
        if not keep.all():
            tracks.keep(keep)

    def _initiate(self, nobodys: Areas, predicted: Floats, picture: Picture) -> None:
        """Start targets on areas that are unassigned in two frames; predicted: others' boxes."""
        follows = self.config.follow_foreground
        nobodys = nobodys.take(np.asarray(follows | ~nobodys.cut.any(axis=1)))
        new = self._initiation.candidates(nobodys, self._clock.now)
        if follows:
            new = new.take(resume(self._tracks, self._spline, new.areas, self._clock.now))
        free = self.config.max_targets - len(self._tracks)
        if not len(new) or free <= 0:
            return
        outlines = [new.areas.outline(k, self.config.outline) for k in range(len(new))]
        nodes = np.array([equally_spaced(each, self._spline) for each in outlines])
        encloses = self._spline.area(nodes) > 1  # [px^2]; a line's is about 0
        encloses &= encloses.cumsum() <= free
        new, nodes = new.take(encloses), nodes[encloses]
        contours = Contours.new(nodes, new.velocity / self.config.rate, self.config)
        records = begin(self._tracks, contours, self._spline, self._clock.now)
        remember(records, new.areas, picture)
        records['by_area'] = self.config.outline == 'area'
        records['inner'] = is_within(new.areas.box, predicted)
