"""The window tracker: frames in, tracks out."""

import numpy as np
from numpy.typing import ArrayLike
from numpy.typing import NDArray

from colortrack_ros.columns import whole_rows
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Frame
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import Tracks
from colortrack_ros.estimation.clock import Clock
from colortrack_ros.estimation.track_table import is_inside
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.estimation.waiting_boxes import WaitingBoxes
from colortrack_ros.windows.appearance import Appearance
from colortrack_ros.windows.config import LEAST_SIDE
from colortrack_ros.windows.config import WindowConfig
from colortrack_ros.windows.lasting import bias_of_box
from colortrack_ros.windows.lasting import biases
from colortrack_ros.windows.lasting import drift
from colortrack_ros.windows.lasting import sizes
from colortrack_ros.windows.legible import legible
from colortrack_ros.windows.matching import match_templates
from colortrack_ros.windows.matching import Matches
from colortrack_ros.windows.motion import agreed
from colortrack_ros.windows.motion import Motion
from colortrack_ros.windows.past import Past
from colortrack_ros.windows.sighting import are_doubtful
from colortrack_ros.windows.sighting import are_faint
from colortrack_ros.windows.sighting import learn
from colortrack_ros.windows.sighting import left_out
from colortrack_ros.windows.sighting import record_scores
from colortrack_ros.windows.sighting import sight
from colortrack_ros.windows.starting import are_centered_in
from colortrack_ros.windows.starting import are_followable
from colortrack_ros.windows.starting import centers
from colortrack_ros.windows.swarm import Swarm
from colortrack_ros.windows.template import Template

STEPS = 4
"""Number of recent velocities by matching that have to agree before a target coasts at their mean.
4 is the least number whose variance shows more than that two happen to be alike."""

WINDOW_FIELDS = [
    ('template', 'O'), ('appearance', 'O'), ('area', 'f4'), ('box_w', 'f4'), ('box_h', 'f4'),
    ('similarity', 'f8'), ('mean_innovation', 'f8'), ('last', 'f8', (2, 2)),
    ('drift', 'f8', (2, 2)), ('bias', 'f8', (2, 2)), ('steps', 'f8', (STEPS, 2)),
    ('seen', 'f8', 2), ('looks', 'i8'), ('turns', 'i8'), ('unfound', 'i8'), ('followed', 'i8'),
    ('faint', '?'), ('company', 'O'), ('score', 'f8'),
]  # fmt: skip
"""Fields of a target in addition to those of every track.

template: the Template; appearance: the Appearance, with config.appearance; area, box_w, box_h: of
the box [px]; similarity: of the last valid match, 0 before the first; mean_innovation: mean norm
[px], infinite before the first; last: (u, v) by matching and by the filter in the last frame [px];
drift: covariance of the template's drift on the object [px^2]; bias: of what lasts of the error of
the last match, or of the first box [px^2]; steps: the last velocities by matching [px/s], NaN:
none; seen: (u, v) of the last match [px]; looks: frames without a match since the target was last
seen for certain; turns: frames in which its size or its appearance was learned; unfound: since its
template was last found; followed: when it was last seen, even if in doubt [ns]; faint: see
are_faint; company: IDs of those at its place at first, 0: not known; score: 1 at first."""


class WindowTracker:
    """Tracks a few dozen targets by template matching (Vidal 2009, chapters 3 to 5).

    :param config: see WindowConfig.
    :param targets: boxes to start in the first frame, and again after each restart; see start.
    :ivar waiting: boxes that wait for the next frame.
    :ivar surfaces: of the last frame; see Matches and reliability_map. trouble: always empty.
    """

    def __init__(self, config: WindowConfig | None = None, targets: ArrayLike = ()) -> None:
        self.config, self.waiting = config or WindowConfig(), WaitingBoxes(targets)
        self._swarm, self._clock, self.trouble = Swarm(self.config), Clock(), ''
        self._kind = ''
        self.surfaces: list[tuple[Indices, NDArray, int]] = []
        self._start(1)

    def _start(self, first_id: int) -> None:
        none = Motion.of_new(np.zeros((0, 2)), self.config)
        self._tracks, self._past = TrackTable(none, WINDOW_FIELDS, first_id), Past()

    def reset(self, why: str = '') -> None:
        """Delete all targets, and start the first ones again. IDs continue: none is used twice.

        :param why: the reason that the next Tracks report.
        """
        self._clock.restart(why)
        self.waiting.restart()
        self._start(self._tracks.next_id)

    def configure(self, config: WindowConfig) -> None:
        """Change the configuration and keep the targets."""
        self.config, self._swarm = config, Swarm(config)
        self._tracks.filters.forget_velocities(config)

    def start(self, boxes: ArrayLike) -> None:
        """Start a target on each box in the next frame.

        :param boxes: (N, 4) u, v of the top left pixel, width and height [px].
        """
        self.waiting.add(boxes, offered=False)

    def offer(self, boxes: ArrayLike) -> None:
        """Start targets in the next frame on boxes where there is none yet; see start."""
        self.waiting.add(boxes, offered=True)

    def update(self, frame: Frame) -> Tracks:
        """Process the next frame.

        A frame older than the last one restarts the tracker, and so does one that has lost its
        color, or got one: no template is like it. Frames that merely arrive late are
        sorted in, or dropped and counted, before they get here (flow.order).

        :raises ValueError: if the encoding is unknown or does not fit the picture's shape.
        :return: the tracks at its stamp, with its header.
        """
        frame = legible(frame)
        self._see('gray' if frame.encoding == 'mono8' else 'color')
        dt = self._clock.advance(frame.stamp, self.config.max_dt, self.reset)
        predicted = self._tracks.filters.predict(dt, self.config)
        matches = self._match(frame, predicted)
        valid = matches.are_valid(self._tracks.records['similarity'], self.config)
        self.surfaces = matches.surfaces
        given = frame, self._tracks.records, matches, valid, predicted, self._past
        sightings = sight(*given) if self._is_learning else {}
        accepted = self._supervise(matches, valid, predicted)
        overdue = self._tracks.is_overdue(self._clock.now, self.config.max_time_since_update)
        certain = accepted & ~are_doubtful(self._tracks.records, matches, sightings, overdue)
        faint = are_faint(self._tracks.records, matches, sightings, accepted)
        self._tracks.records['faint'] = faint
        record_scores(self._tracks.records, matches, sightings, accepted)
        self._correct(matches, accepted, certain & ~faint, dt)
        if self._is_learning:
            learn(frame, self._tracks.records, certain, matches, sightings)
        self._renew_templates(frame, matches, accepted & (certain | ~overdue))
        self._delete(frame)
        boxes, offered = self.waiting.take()
        self._initiate(frame, boxes[~offered])
        if offered.any():
            position = self._tracks.filters.bank.estimate()[0][:, :2]
            followed = are_centered_in(boxes, position, sizes(self._tracks.records))
            self._initiate(frame, boxes[offered & ~followed])
        if self._is_learning:
            self._past.keep(frame, self._tracks.records)
        return Tracks(self._rows(frame), frame.stamp, frame.frame_id, self._clock.tell_restart())

    def _see(self, kind: str) -> None:
        before, self._kind = self._kind, kind
        if before not in (kind, ''):
            self.reset(f'the pictures changed from {before} to {kind}')

    def _match(self, frame: Frame, predicted: Floats) -> Matches:
        records, regions = self._tracks.records, self._tracks.filters.search_regions(self.config)
        templates, innovation = records['template'].tolist(), records['mean_innovation']
        skipped = left_out(records) if self._is_learning else ()
        given = predicted, regions, innovation, self.config, skipped
        return match_templates(frame, templates, *given)

    @property
    def _is_learning(self) -> bool:
        return self.config.appearance and self.config.drift_compensation

    def _supervise(self, matches: Matches, valid: Bools, predicted: Floats) -> Bools:
        """Which targets are measured, (N,): True for the match, False for the prediction alone.

        Implements the measure of confidence and the tolerance of 4.3.1. Match and prediction
        disagree if u and v differ by more than the tolerance on average. Then either the valid
        match is right and the filter has to learn a new velocity, or the one that moved farther
        since the last frame is wrong.
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
        """Update filters and records with the accepted matches.

        :param certain: (N,) which of them count as hits.
        """
        track, records = np.flatnonzero(accepted), self._tracks.records
        if dt > 0:
            self._note_steps(matches, accepted, dt)
        R = matches.R[track]
        R[np.isnan(R).any(axis=(1, 2))] = np.eye(2)
        self._tracks.filters.bank.correct(track, matches.z[track], R)
        if self.config.method == 'WM+K+PSO' and dt > 0 and len(track):
            step = matches.z[track] - records['last'][track, 0]
            # After a gap there is no velocity by matching: the last position was a prediction.
            last_frame = self._clock.now - round(dt * NANOSECONDS)
            step[records['followed'][track] < last_frame] = np.nan
            step[~matches.are_sharp(self.config.max_deviation)[track]] = np.nan
            self._tracks.filters.steer(self._swarm, track, step, dt)
        self._tracks.record_hits(np.flatnonzero(certain), self._clock.now)
        records['seen'][track], records['followed'][track] = matches.z[track], self._clock.now
        alike = track[matches.similarity[track] > 0]  # not sightings by appearance
        records['similarity'][alike] = matches.similarity[alike]
        records['bias'][track] = biases(records, track, matches, self.config.box_error)
        mean, norm = records['mean_innovation'], matches.innovation_norm
        step = norm - np.where(np.isinf(mean), 0.0, mean)
        usual = accepted & np.isfinite(norm) & (matches.alone | (norm <= mean))
        step /= np.maximum(records['hits'] - 1, 1)
        mean[usual] = np.where(np.isinf(mean), norm, mean + step)[usual]

    def _note_steps(self, matches: Matches, accepted: Bools, dt: float) -> None:
        """Record velocities by matching; targets that start to coast keep theirs if they agree."""
        records = self._tracks.records
        sure = matches.are_sharp(self.config.tolerance)
        before = records['followed'] >= self._clock.now - round(dt * NANOSECONDS)
        lost = np.flatnonzero(~accepted & before & (records['hits'] > 1))
        if len(lost) and self.config.method != 'WM':
            self._tracks.filters.bank.set_velocity(lost, agreed(records['steps'][lost]))
        going = np.flatnonzero(accepted & before & sure)
        records['steps'][going, 1:] = records['steps'][going, :-1]
        records['steps'][going, 0] = (matches.z[going] - records['seen'][going]) / dt

    def _renew_templates(self, frame: Frame, matches: Matches, accepted: Bools) -> None:
        """Take new templates from this frame: all of them, or a few with drift compensation.

        A template's error persists as long as its successors are found with it. With drift
        compensation a template is kept until the target looks clearly less like it than at first.
        """
        records, compensated = self._tracks.records, self.config.drift_compensation
        position = self._tracks.filters.bank.estimate()[0][:, :2]
        place = np.where(accepted[:, None], matches.z, position)
        records['last'] = np.stack([place, position], axis=1)
        sharp = accepted & ~records['faint'] & matches.are_sharp(self.config.max_deviation)
        for i, (crop, template) in enumerate(zip(matches.crops, records['template'], strict=True)):
            if compensated:
                alike = float(matches.similarity[i]), float(matches.correlation[i])
                worn = sharp[i] and template.record_match(*alike, self.config.renewal)
            else:
                worn = crop is not None
            if worn:
                records['drift'][i] = drift(records, i, matches, compensated)
                records['template'][i] = template.renewed(frame, place[i])
            elif compensated and not accepted[i] and template.former:
                # It may show what covers the target: alternate with the one before.
                former, template.former = template.former, None
                former.former = template
                records['template'][i] = former

    def _delete(self, frame: Frame) -> None:
        """Delete targets unseen for too long, and without appearance those outside the picture."""
        longest = round(self.config.max_time_since_update * NANOSECONDS)
        kept = self._clock.now - self._tracks.records['followed'] <= longest
        if not self._is_learning:
            position = self._tracks.filters.bank.estimate()[0][:, :2]
            kept &= is_inside(position, *frame.image.shape[:2])
        if not kept.all():
            self._tracks.keep(kept)

    def _initiate(self, frame: Frame, boxes: Floats) -> None:
        """Start targets on boxes."""
        if not len(boxes):
            return
        free = max(self.config.max_targets - len(self._tracks), 0)
        kept = boxes[are_followable(frame, boxes, self.config)][:free]
        self.waiting.refused += len(boxes) - len(kept)
        center, box = centers(kept), kept[:, 2:]
        new = self._tracks.initiate(Motion.of_new(center, self.config), self._clock.now)
        new['mean_innovation'], new['steps'], new['area'] = np.inf, np.nan, box.prod(axis=1)
        new['last'], new['seen'], new['followed'] = center[:, None], center, self._clock.now
        new['score'], (new['box_w'], new['box_h']) = 1.0, box.T
        new['bias'] = bias_of_box(box, self.config.box_error)
        self._past.begin(frame, new['track_id'].tolist(), np.concatenate([center, box], axis=1))
        wanted = self.config.window or np.maximum(box, LEAST_SIDE)
        size = np.array(frame.image.shape[1::-1])
        odd = np.broadcast_to(np.minimum(wanted, size).astype(int) - 1 | 1, box.shape)
        for i, (w, h) in enumerate(odd.tolist()):
            new['template'][i] = Template.of(frame, center[i], w, h)
            if self._is_learning:
                new['appearance'][i] = Appearance(frame, center[i], box[i])

    def _rows(self, frame: Frame) -> NDArray[np.void]:
        """The tracks in the picture as published; all are confirmed from the start."""
        now, records = self._clock.now, self._tracks.records
        self._tracks.update_states(now, 1)
        rows = self._tracks.rows(now, *self._tracks.filters.bank.estimate())
        rows['covariance'][:, :2, :2] += records['drift'] + records['bias']
        rows['score'] = records['score']
        rows['score'] *= self._tracks.freshness(now, self.config.max_time_since_update)
        place = np.stack([rows['u'], rows['v']], axis=1)
        return whole_rows(rows)[is_inside(place, *frame.image.shape[:2])].view(rows.dtype)
