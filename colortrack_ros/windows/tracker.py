"""The window tracker: a frame in, tracks out."""

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.encodings import check
from colortrack_ros.encodings import plain
from colortrack_ros.estimation.clock import Clock
from colortrack_ros.estimation.track_table import is_inside
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.estimation.waiting_boxes import WaitingBoxes
from colortrack_ros.windows.appearance import Appearance
from colortrack_ros.windows.appearance import Sighting
from colortrack_ros.windows.config import WindowConfig
from colortrack_ros.windows.matching import match_templates
from colortrack_ros.windows.matching import Matches
from colortrack_ros.windows.motion import Bools
from colortrack_ros.windows.motion import Floats
from colortrack_ros.windows.motion import Motion
from colortrack_ros.windows.sighting import are_doubtful
from colortrack_ros.windows.sighting import learn
from colortrack_ros.windows.sighting import sight
from colortrack_ros.windows.starting import are_followable
from colortrack_ros.windows.starting import centers
from colortrack_ros.windows.starting import LEAST_SIDE
from colortrack_ros.windows.swarm import Swarm
from colortrack_ros.windows.template import Template

STEPS = 4
"""Velocities of matches that have to agree before a target coasts by theirs: the least number whose
variance says more than that two are alike."""

WINDOW_FIELDS = [
    ('template', 'O'),
    ('appearance', 'O'),
    ('area', 'f4'),
    ('box_w', 'f4'),
    ('box_h', 'f4'),
    ('similarity', 'f8'),
    ('mean_innovation', 'f8'),
    ('last', 'f8', (2, 2)),
    ('drift', 'f8', (2, 2)),
    ('steps', 'f8', (STEPS, 2)),
    ('seen', 'f8', 2),
    ('looks', 'i8'),
    ('followed', 'i8'),
]
"""What is recorded of a target besides what is of every track.

template: the Template; appearance: the Appearance, with config.appearance; area, box_w, box_h: of
the box [px]; similarity: of the last valid match, 0 before the first; mean_innovation: mean norm
[px], infinite before the first;
last: (u, v) by matching and by the filter in the last frame [px]; drift: covariance of what the
template has moved on the object [px^2]; steps: the last velocities by matching [px/s], NaN: none;
seen: (u, v) of the last match [px]; looks: frames without it since it was last seen for sure;
followed: when it was last seen, be it in doubt [ns].
"""


class WindowTracker:
    """Follows the pictures of a few dozen targets (Vidal 2009, chapters 3 to 5).

    :param config: see WindowConfig.
    :param targets: boxes to start with the first frame, and again after each restart; see start.
    :ivar waiting: boxes that wait for the next frame.
    :ivar surfaces: of the last frame; see Matches and reliability_map.
    """

    def __init__(self, config: WindowConfig | None = None, targets: ArrayLike = ()) -> None:
        self.config, self.waiting = config or WindowConfig(), WaitingBoxes(targets)
        self._swarm, self._clock = Swarm(self.config), Clock()
        self.surfaces: list[tuple[NDArray[np.intp], NDArray, int]] = []
        self._start(1)

    def _start(self, first_id: int) -> None:
        none = Motion.of_new(np.zeros((0, 2)), self.config)
        self._tracks = TrackTable(none, WINDOW_FIELDS, first_id)

    def reset(self, why: str = '') -> None:
        """Forget all targets, and start the first ones again. IDs go on: none is used twice.

        :param why: what the next Tracks tell as the reason.
        """
        self._clock.restart(why)
        self.waiting.restart()
        self._start(self._tracks.next_id)

    def configure(self, config: WindowConfig) -> None:
        """Change the configuration; the targets live on."""
        self.config, self._swarm = config, Swarm(config)
        self._tracks.filters.forget_velocities(config)

    def start(self, boxes: ArrayLike) -> None:
        """Follow what is inside the boxes in the next frame.

        :param boxes: (N, 4) u, v of the top left pixel, width and height [px].
        """
        self.waiting.add(boxes, offered=False)

    def offer(self, boxes: ArrayLike) -> None:
        """Follow what is inside the boxes in the next frame, where no target is yet; see start."""
        self.waiting.add(boxes, offered=True)

    def update(self, frame: Frame) -> Tracks:
        """Take the next frame.

        One that is older than the last starts afresh: what only comes late is sorted in or dropped,
        and counted, before it comes here (flow.order).

        :raises ValueError: when the encoding is not known or does not fit the picture's shape.
        :return: the tracks at its stamp, with its header.
        """
        check(frame)
        frame = plain(frame)
        dt = self._clock.advance(frame.stamp, self.config.max_dt, self.reset)
        predicted = self._tracks.filters.predict(dt, self.config)
        matches = self._match(frame, predicted)
        valid, self.surfaces = self._validate(matches), matches.surfaces
        sightings: dict[int, Sighting] = {}
        if self._is_learning:
            sightings = sight(frame, self._tracks.records, matches, valid, predicted)
        accepted = self._supervise(matches, valid, predicted)
        certain = accepted & ~are_doubtful(self._tracks.records, matches, sightings)
        self._correct(matches, accepted, certain, dt)
        if self._is_learning:
            learn(frame, self._tracks.records, certain, matches, sightings)
        self._renew_templates(frame, matches, accepted)
        self._delete(frame)
        boxes, offered = self.waiting.take()
        self._initiate(frame, boxes[~offered])
        self._initiate(frame, self._unfollowed(boxes[offered]))
        return Tracks(self._rows(), frame.stamp, frame.frame_id, self._clock.tell_restart())

    def _match(self, frame: Frame, predicted: Floats) -> Matches:
        records, regions = self._tracks.records, self._tracks.filters.search_regions(self.config)
        templates, innovation = records['template'].tolist(), records['mean_innovation']
        return match_templates(frame, templates, predicted, regions, innovation, self.config)

    @property
    def _is_learning(self) -> bool:
        return self.config.appearance and self.config.drift_compensation

    def _validate(self, matches: Matches) -> Bools:
        """Which matches of templates are to be trusted, (N,)."""
        if self.config.drift_compensation:
            return matches.are_valid(self._tracks.records['similarity'], self.config)
        return np.asarray(~np.isnan(matches.similarity))

    def _supervise(self, matches: Matches, valid: Bools, predicted: Floats) -> Bools:
        """Which targets are measured, (N,): True for the match, False for the prediction alone.

        The measure of confidence and tolerance of 4.3.1. They disagree when u and v differ by more
        than the tolerance on average. Then either the valid match is right and the filter has to
        learn another velocity, or whichever has moved farther since the last frame is wrong.
        """
        config, z, last = self.config, matches.z, self._tracks.records['last']
        accepted = valid.copy()
        if config.method == 'WM':
            return accepted
        disagree = np.abs(z - predicted).mean(axis=1) > config.tolerance
        if config.supervision == 'discrepancy':
            matched = np.abs(z - last[:, 0]).mean(axis=1)
            moved = np.abs(predicted - last[:, 1]).mean(axis=1)
            accepted &= ~disagree | (matched <= moved)
        track = np.flatnonzero(accepted & disagree)
        if len(track):
            unmeasured = self._tracks.unmeasured(self._clock.now)[track]
            self._tracks.filters.turn(track, z[track] - predicted[track], unmeasured)
        return accepted

    def _correct(self, matches: Matches, accepted: Bools, certain: Bools, dt: float) -> None:
        """Update filters and records with the matches that are accepted.

        :param certain: (N,) those that count as seen.
        """
        track, records = np.flatnonzero(accepted), self._tracks.records
        if dt > 0:
            self._note_steps(matches, accepted, dt)
        R = matches.R[track]
        R[np.isnan(R).any(axis=(1, 2))] = np.eye(2)
        self._tracks.filters.bank.correct(track, matches.z[track], R)
        if self.config.method == 'WM+K+PSO' and dt > 0 and len(track):
            step = matches.z[track] - records['last'][track, 0]
            # After a gap matching tells no velocity: in the last frame it was a prediction.
            last_frame = self._clock.now - round(dt * NANOSECONDS)
            step[records['followed'][track] < last_frame] = np.nan
            step[~matches.are_sharp(self.config.max_deviation)[track]] = np.nan
            self._tracks.filters.steer(self._swarm, track, step, dt)
        self._tracks.record_hits(np.flatnonzero(certain), self._clock.now)
        records['seen'][track], records['followed'][track] = matches.z[track], self._clock.now
        alike = track[matches.similarity[track] > 0]  # not of what was seen beside the template
        records['similarity'][alike] = matches.similarity[alike]
        mean, norm = records['mean_innovation'], matches.innovation_norm
        step = norm - np.where(np.isinf(mean), 0.0, mean)
        usual = accepted & (matches.alone | (norm <= mean))
        share = 1 / np.maximum(records['hits'] - 1, 1)
        usual &= np.isfinite(norm)
        mean[usual] = np.where(np.isinf(mean), norm, mean + share * step)[usual]

    def _note_steps(self, matches: Matches, accepted: Bools, dt: float) -> None:
        """Keep the last velocities by matching; who begins to coast goes on as far as they agree.

        A velocity of mean m whose variance from frame to frame is s^2 is shrunk by
        m^2 / (m^2 + s^2), which leaves the least squared error: nothing if matches jump about.
        """
        records, motion = self._tracks.records, self._tracks.filters
        sure = matches.are_sharp(self.config.tolerance)
        before = records['followed'] >= self._clock.now - round(dt * NANOSECONDS)
        lost = np.flatnonzero(~accepted & before & (records['hits'] > 1))
        if len(lost) and self.config.method != 'WM':
            steps = records['steps'][lost]
            known = ~np.isnan(steps).any(axis=(1, 2))
            mean = np.square(steps.mean(axis=1)).sum(axis=1)
            spread = steps.var(axis=1).sum(axis=1)
            share = np.where(known, mean / np.maximum(mean + spread, 1e-9), 0.0)
            motion.bank.set_velocity(lost, np.nan_to_num(steps.mean(axis=1)) * share[:, None])
        going = np.flatnonzero(accepted & before & sure)
        records['steps'][going, 1:] = records['steps'][going, :-1]
        records['steps'][going, 0] = (matches.z[going] - records['seen'][going]) / dt

    def _renew_templates(self, frame: Frame, matches: Matches, accepted: Bools) -> None:
        """Take new templates from this frame: all of them, or with drift compensation few.

        A template's error stays with the target as long as its successors are found by it, so each
        is kept until the target looks clearly less like it than in the beginning.
        """
        records, compensated = self._tracks.records, self.config.drift_compensation
        position = self._tracks.filters.bank.estimate()[0][:, :2]
        place = np.where(accepted[:, None], matches.z, position)
        records['last'] = np.stack([place, position], axis=1)
        sharp = accepted & matches.are_sharp(self.config.max_deviation)
        for i, (crop, template) in enumerate(zip(matches.crops, records['template'], strict=True)):
            if compensated:
                alike = float(matches.similarity[i]), float(matches.correlation[i])
                worn = sharp[i] and template.record_match(*alike, self.config.renewal)
            else:
                worn = crop is not None
            if worn:
                records['drift'][i] += np.nan_to_num(matches.R[i])
                records['template'][i] = template.renewed(frame, place[i])
            elif compensated and not accepted[i] and template.former:
                # It may have taken on what covers the target: try the one before, by turns.
                former, template.former = template.former, None
                former.former = template
                records['template'][i] = former

    def _delete(self, frame: Frame) -> None:
        """Delete targets whose center has left the picture, or that were not even seen in doubt."""
        position = self._tracks.filters.bank.estimate()[0][:, :2]
        longest = round(self.config.max_time_since_update * NANOSECONDS)
        overdue = self._clock.now - self._tracks.records['followed'] > longest
        self._tracks.keep(is_inside(position, *frame.image.shape[:2]) & ~overdue)

    def _unfollowed(self, boxes: Floats) -> Floats:
        """Those whose centers are in no target's box."""
        if not len(boxes):
            return boxes
        records, position = self._tracks.records, self._tracks.filters.bank.estimate()[0][:, :2]
        half = np.stack([records['box_w'], records['box_h']], axis=1) / 2
        inside = np.all(np.abs(centers(boxes)[:, None] - position) <= half, axis=2)
        return boxes[~np.any(inside, axis=1)]

    def _initiate(self, frame: Frame, boxes: Floats) -> None:
        """Begin targets with the windows in boxes."""
        if not len(boxes):
            return
        free = max(self.config.max_targets - len(self._tracks), 0)
        kept = boxes[are_followable(frame, boxes, self.config)][:free]
        self.waiting.refused += len(boxes) - len(kept)
        center, box = centers(kept), kept[:, 2:]
        new = self._tracks.initiate(Motion.of_new(center, self.config), self._clock.now)
        new['mean_innovation'], new['last'] = np.inf, center[:, None]
        new['box_w'], new['box_h'] = box.T
        new['area'] = new['box_w'] * new['box_h']
        wanted = self.config.window or np.maximum(box, LEAST_SIDE)
        size = np.array(frame.image.shape[1::-1])
        odd = np.broadcast_to(np.minimum(wanted, size).astype(int) - 1 | 1, box.shape)
        new['seen'], new['steps'], new['followed'] = center, np.nan, self._clock.now
        for i, (w, h) in enumerate(odd.tolist()):
            new['template'][i] = Template.of(frame, center[i], w, h)
            if self._is_learning:
                new['appearance'][i] = Appearance(frame, center[i], box[i])

    def _rows(self) -> NDArray[np.void]:
        """The tracks as they are published; all are confirmed from the first."""
        now, records = self._clock.now, self._tracks.records
        self._tracks.update_states(now, 1)
        rows = self._tracks.rows(now, *self._tracks.filters.bank.estimate())
        rows['covariance'][:, :2, :2] += records['drift']
        similarity = np.where(records['hits'] > 1, records['similarity'], 1.0)
        fresh = self._tracks.freshness(now, self.config.max_time_since_update)
        rows['score'] = np.clip(similarity, 0, 1) * fresh
        return rows
