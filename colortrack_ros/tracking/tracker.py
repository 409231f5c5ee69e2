"""The tracker: detections of one frame in, tracks out."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Detections
from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import Tracks
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.clock import Clock
from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.adaptation import SLOW_PERIOD
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.crossings import defer
from colortrack_ros.tracking.crossings import tell_apart
from colortrack_ros.tracking.deletion import confirm
from colortrack_ros.tracking.deletion import go_on
from colortrack_ros.tracking.deletion import is_present
from colortrack_ros.tracking.doubts import doubt
from colortrack_ros.tracking.doubts import DoubtedTurns
from colortrack_ros.tracking.doubts import join
from colortrack_ros.tracking.doubts import reconsider
from colortrack_ros.tracking.duplicates import leave_out_points
from colortrack_ros.tracking.fast_starts import start_fast
from colortrack_ros.tracking.flicker import TELLING_HITS
from colortrack_ros.tracking.gating import gate
from colortrack_ros.tracking.hypotheses import choose_hypotheses
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.hypotheses import hypothesize
from colortrack_ros.tracking.hypotheses import score
from colortrack_ros.tracking.initiation import initiate
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.memory import Memory
from colortrack_ros.tracking.merge_split import merge_split
from colortrack_ros.tracking.population import Population
from colortrack_ros.tracking.prediction import assumed_speed
from colortrack_ros.tracking.prediction import coast
from colortrack_ros.tracking.prediction import predict
from colortrack_ros.tracking.prediction import predict_with_camera
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.prediction import Step
from colortrack_ros.tracking.records import FIELDS
from colortrack_ros.tracking.records import published
from colortrack_ros.tracking.repeats import Repeats
from colortrack_ros.tracking.rhythm import Rhythm
from colortrack_ros.tracking.screening import Screening
from colortrack_ros.tracking.several_detectors import by_kind
from colortrack_ros.tracking.several_detectors import found_before
from colortrack_ros.tracking.stitching import find_stitches
from colortrack_ros.tracking.stitching import stitch
from colortrack_ros.tracking.strays import take_strays
from colortrack_ros.tracking.turns import UndecidedTurns
from colortrack_ros.tracking.unresolved import follow_shared
from colortrack_ros.tracking.unresolved import share_centroids
from colortrack_ros.tracking.update import update

FIRST_PERIOD = 1 / 30
"""Frame period assumed until two frames have arrived [s]: that of a usual camera."""

AFRESH = ('motion_model', 'acceleration', 'trust', 'population')
"""Parameters that determine the state of tracks: when one of them changes, the tracker restarts."""

USUALLY = 0.8
"""Share of the tracks of which blobs say that they go on as predicted, above which nobody looks for
the camera's motion: 95 % are detected, and few turn. Assumed."""


class Tracker:
    """Many objects, one Kalman filter each (Pegoretti 2021, 3.1.2, its faults mended).

    :param config: see TrackerConfig.
    :ivar repeats: number of repeated pictures. screening: refuses and tells what is invalid.
    """

    def __init__(self, config: TrackerConfig | None = None) -> None:
        self.config = config or TrackerConfig()
        self.screening, self.repeats, self._clock = Screening(), 0, Clock(follows=True)
        self._start(1)

    def _start(self, first_id: int) -> None:
        config = self._in_force = self.config
        model = MOTION_MODELS[config.motion_model](config.acceleration, config.trust)
        self._population = Population(self.config.population)
        first_id = max(first_id, self._population.total + 1)
        self._tracks = TrackTable(Bank(model), FIELDS, first_id)
        self._memory = Memory(self._tracks.take(np.zeros(0, np.intp)), self._population)
        self._adaptation = Adaptation(config.max_time_since_update)
        self._doubts: DoubtedTurns | None = None
        self._period, self._turns = FIRST_PERIOD, UndecidedTurns(model)
        self._repeats, self._rhythm = Repeats(), Rhythm()

    def reset(self, why: str = '') -> None:
        """Drop all tracks. IDs continue: none is used twice.

        :param why: the reason, published with the next Tracks.
        """
        self._clock.restart(why)
        self._start(self._tracks.next_id)

    def configure(self, config: TrackerConfig) -> None:
        """Change the configuration; the tracker restarts if a parameter in AFRESH changes."""
        old, self.config = self.config, config
        self._in_force = self._adaptation.patient(config)
        if old.ego_motion != config.ego_motion:
            self._stop_camera()
        for name in AFRESH:
            before, now = getattr(old, name), getattr(config, name)
            if before != now:
                self.reset(f'{name} changed from {before} to {now}')
                return

    def update(self, detections: Detections) -> Tracks:
        """Process the detections of one frame.

        A message with the stamp of the last one adds detections of the same moment: repeated rows
        are dropped and counted, tracks that already have a measurement take none, what lies on them
        starts none, and a track without one does not count as missed again.

        :param detections: of the next frame, which may be empty.
        :return: the tracks at its stamp, with its header.
        """
        if self._repeats.see(detections, self._clock, self._in_force.max_dt):
            return self._between(detections)
        for part in by_kind(detections, self.config):
            speed = self._take(part)
        return self._published(self._tracks, detections, speed)

    def _take(self, detections: Detections) -> Floats:
        """Process detections of one detector; returns what Prediction.speed is."""
        step = self._advance(detections)
        config, tracks, learned = self._in_force, self._tracks, self._adaptation
        blobs = self.screening.measure(detections, learned, config, again=step.again)
        doubts = reconsider(tracks, self._doubts, blobs, learned, config, step)
        prediction = predict(tracks, blobs, learned, config, step)
        self._follow_camera(step)
        prediction, hypotheses = self._hypothesize(prediction, blobs)
        gain = score(hypotheses, prediction, blobs, config)
        associated = choose_hypotheses(hypotheses, gain, blobs.rows.size, config.associator)
        defer(hypotheses, gain, associated, prediction, blobs)
        blobs, associated = merge_split(prediction, blobs, associated, learned.overlaps)
        associated, shared = share_centroids(prediction, blobs, associated, learned.resolution)
        associated = take_strays(prediction, blobs, associated, shared, config)
        if not prediction.sized:
            associated = leave_out_points(prediction, blobs, associated, learned.overlaps)
        self._doubts = join(doubts, doubt(prediction, associated))
        update(tracks, prediction, blobs, associated, learned, self._turns, config)
        if shared is not None:
            follow_shared(tracks, shared, prediction, blobs)
        tell_apart(tracks, associated.pairs, prediction, config)
        free = associated.free
        if step.again:
            free = free & ~found_before(prediction, blobs)
        new = free.nonzero()[0]
        if new.size:
            new = learned.overlaps.may_start(new, blobs.rows, config.start_score)
            initiate(tracks, prediction, blobs, start_fast(tracks, prediction, blobs, new, learned))
        self._manage(again=step.again)
        return prediction.speed

    def _between(self, detections: Detections) -> Tracks:
        """The tracks at the stamp of a repeated picture; they and all that is learned stay."""
        learned, config = self._adaptation, self._in_force
        self.repeats += 1
        dt = (detections.stamp - self._clock.now) / NANOSECONDS
        tracks = coast(self._tracks, dt, learned, config)
        return self._published(tracks, detections, assumed_speed(learned, config))

    def _published(self, tracks: TrackTable[Bank], detections: Detections, speed: Floats) -> Tracks:
        """The tracks, with the header of the detections."""
        learned, config, population = self._adaptation, self._in_force, self._population

        def detector() -> tuple[float, bool]:
            rate = learned.detection_rate.estimate(config.detection_probability)
            return rate, learned.finds_whole

        existence = learned.disappearances.existence(
            tracks.records, learned.area, self._clock.now, self._period, detector
        )
        rows = published(tracks, detections.stamp, config, population, speed, existence)
        learned.camera.publish(rows, tracks)
        return Tracks(rows, detections.stamp, detections.frame_id, self._clock.tell_restart())

    def _follow_camera(self, step: Step) -> None:
        """Move remembered tracks with the camera; once steady, its motion becomes the tracks'."""
        camera = self._adaptation.camera
        if not (camera.stands or step.again):
            camera.carry(self._memory.tracks)
        if camera.is_steady:
            self._stop_camera()

    def _stop_camera(self) -> None:
        """Add the camera's motion to that of all tracks, remembered ones included."""
        camera = self._adaptation.camera
        for tracks in (self._tracks, self._memory.tracks):
            camera.give(tracks, self._adaptation.recent, self._clock.now)
        camera.stop()

    def _advance(self, detections: Detections) -> Step:
        """Advance to the stamp of the detections, or restart."""
        again = self._clock.is_now(detections.stamp)
        dt = self._clock.advance(detections.stamp, self._in_force.max_dt, self.reset)
        self._period = dt or self._period
        if self._period > SLOW_PERIOD or self._adaptation.slow_periods:  # else nothing changes
            self._adaptation.learn_period(self._period)
            self._in_force = self._adaptation.patient(self.config)
        if self.config.ego_motion == 'odometry' and not again:
            self._adaptation.camera.turn(detections.viewpoint, self._clock.now, self._period)
        pauses = self._rhythm.is_pause(detections.rows.size, again=again)
        return Step(self._clock.now, dt, self._period, again, pauses)

    def _hypothesize(
        self, prediction: Prediction, blobs: Measurements
    ) -> tuple[Prediction, Hypotheses]:
        """Compare blobs with tracks, and again if the camera turns out to have moved."""
        config, step = self._in_force, prediction.step
        track, blob = gate(prediction, blobs, config)
        hypotheses = hypothesize(prediction, blobs, track, blob)
        prior = prediction.maneuvered[hypotheses.track]
        going_on = np.count_nonzero(hypotheses.innovations.maneuvered <= prior)
        if going_on < USUALLY * len(prediction.center):
            again = predict_with_camera(self._tracks, blobs, self._adaptation, config, step)
            if again:
                self._follow_camera(step)
                return again, hypothesize(again, blobs, *gate(again, blobs, config))
        return prediction, hypotheses

    def _manage(self, *, again: bool) -> None:
        """Confirmation, deletion and stitching."""
        tracks, now, learned = self._tracks, self._clock.now, self._adaptation
        config = self._in_force
        records = tracks.records
        if go_on(tracks, now, config):
            if not again:
                learned.learn_new()
            return
        before = records['state'].copy()
        keep = confirm(tracks, now, config)
        overdue = ~keep & (records['state'] == COASTING)
        if np.count_nonzero(overdue):
            gone = overdue & ~(records['outside'] | records['splinter'])
            gone &= records['hits'] >= TELLING_HITS
            learned.disappearances.learn(
                records['seen'][gone], tracks.unmeasured(now)[gone], returned=False
            )
        false = int(np.count_nonzero(~keep & (before == TENTATIVE)))
        keep &= is_present(tracks, now, self._period, learned.image_size, config)
        hidden = ~keep & (records['state'] == COASTING)
        if config.max_hidden <= config.max_time_since_update:
            hidden &= self._population.is_counted(records['color'])
        if np.count_nonzero(hidden):
            records['outside'] &= ~overdue & (not learned.camera.is_known)
            self._memory.remember(tracks.take(hidden), now, learned, config)
        new = (keep & (before == TENTATIVE) & (records['state'] == CONFIRMED)).nonzero()[0]
        stitched = self._stitch(keep, new) if len(new) else new
        others = np.delete(new, stitched) if len(stitched) else new
        if not again:
            learned.learn_new(false, records['origin'][others])
        counted = others[self._population.is_counted(records['color'][others])]
        records['track_id'][counted] = self._population.name(records['color'][counted])
        keep[counted] = records['track_id'][counted] > 0
        if len(new) or np.count_nonzero(keep) < len(keep):
            rows = keep.nonzero()[0]
            rows = rows[np.argsort(records['track_id'][rows])]
            if len(rows) < len(records) or np.count_nonzero(rows[1:] < rows[:-1]):
                tracks.keep(rows)

    def _stitch(self, keep: NDArray[np.bool_], found: NDArray[np.intp]) -> NDArray[np.intp]:
        """Continue lost and remembered tracks as those just confirmed; return which of these.

        :param keep: (N,) which tracks survive; of a stitched pair, the row of the new one does.
        """
        tracks, memory, now, learned = self._tracks, self._memory, self._clock.now, self._adaptation
        memory.advance(now, learned, self._in_force)
        coasting = np.flatnonzero(keep & (tracks.records['state'] == COASTING))
        lost = tracks.take(coasting)
        lost.extend(memory.tracks)
        if not len(lost):
            return found[:0]
        one, other = find_stitches(
            lost, tracks.take(found), now, self._period, learned, self._in_force, self._population
        )
        away = tracks.records['born'][found[other]] - lost.records['updated'][one]
        stitch(tracks, found[other], lost.records.take(one))
        is_live = one < len(coasting)
        seen, away = lost.records['seen'][one], away / NANOSECONDS
        for which, in_time in ((is_live, True), (~is_live, False)):
            learned.disappearances.rejoin(seen[which], away[which], self._period, in_time=in_time)
        keep[coasting[one[is_live]]] = False
        memory.forget(one[~is_live] - len(coasting))
        return other
