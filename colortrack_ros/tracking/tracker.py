"""The tracker: detections of one frame in, tracks out."""

import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import Tracks
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.clock import Clock
from colortrack_ros.estimation.existence import predict_existence
from colortrack_ros.estimation.existence import update_existence
from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking import blobs as shape
from colortrack_ros.tracking import life
from colortrack_ros.tracking import merge_split
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.association import ASSOCIATORS
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.measurements import accept
from colortrack_ros.tracking.measurements import Blobs
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.stitching import reunions

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

ROW = np.dtype((np.void, DETECTION.itemsize))
"""A detection as mere bytes."""

MISTAKEN = math.log(50)
"""What another color costs where it does not gate: the detector mixes up one in so many."""

UNLIKELY = 0.01
"""A maneuver of less probability is left out of account."""


class Tracker:
    """Many objects, one Kalman filter each (Pegoretti 2021, 3.1.2, its faults mended).

    :param config: see TrackerConfig.
    """

    def __init__(self, config: TrackerConfig | None = None) -> None:
        self.config = config or TrackerConfig()
        self.dropped = 0
        """Detections refused so far: not finite, or with a covariance that is none."""
        self.repeated = 0
        """Detections refused so far: the same as before, with the same stamp."""
        self._clock = Clock()
        self._start(1)

    def _start(self, first_id: int) -> None:
        model = MOTION_MODELS[self.config.motion_model](self.config.acceleration)
        self._tracks = TrackTable(Bank(model), life.FIELDS, first_id)
        self._adaptation = Adaptation()
        self._period = 1 / 30
        self._known_rows = np.zeros(0, DETECTION)

    def reset(self, why: str = '') -> None:
        """Forget all tracks. IDs go on: none is used twice.

        :param why: what the next Tracks tell as the reason.
        """
        self._clock.restart(why)
        self._start(self._tracks.next_id)

    def configure(self, config: TrackerConfig) -> None:
        """Change the configuration; tracks live on, unless the motion model is another."""
        old, self.config = self.config, config
        if old.motion_model != config.motion_model:
            self.reset(f'motion_model changed from {old.motion_model} to {config.motion_model}')

    def update(self, detections: Detections) -> Tracks:
        """Take the detections of one frame.

        A message with the stamp of the last one brings more detections of the same moment: rows
        that were there before are dropped and counted, tracks already measured take none, and a
        track that gets none has not been missed once more.

        :param detections: of the next frame; an empty one is a frame as well.
        :return: the tracks at its stamp, with its header.
        """
        again = self._clock.is_now(detections.stamp)
        dt = self._advance(detections.stamp)
        blobs = self._accept(detections.rows, again)
        outlook = self._expect(dt, blobs)
        pairs, share = self._associate(outlook, blobs)
        free = np.ones(len(blobs.rows), bool)
        free[pairs.blob[share > 0.5]] = False
        blobs, pairs, share = self._regroup(outlook, blobs, pairs, share, free)
        self._correct(outlook, blobs, pairs, share, again)
        new = np.flatnonzero(free)
        if len(new):
            life.initiate(self._tracks, blobs, new, self._clock.now, outlook.speed, outlook.noise)
        self._settle(again)
        why = self._clock.tell_restart()
        rows = life.published(self._tracks, self._clock.now, self.config.centroid_bias)
        return Tracks(rows, detections.stamp, detections.frame_id, why)

    def _advance(self, stamp: int) -> float:
        """Go to the stamp, or start afresh; return dt [s]."""
        dt = self._clock.advance(stamp, self.config.max_dt, self.reset)
        self._period = dt or self._period
        return dt

    def _accept(self, rows: NDArray[np.void], again: bool) -> Blobs:
        """The rows that can be used; the others are counted."""
        rows = np.ascontiguousarray(rows)
        if again:
            known = set(self._known_rows.view(ROW).tolist())
            new = np.array([row not in known for row in rows.view(ROW).tolist()], bool)
            self.repeated += len(rows) - int(new.sum())
            rows = rows[new]
            self._known_rows = np.concatenate([self._known_rows, rows], dtype=DETECTION)
        else:
            self._known_rows = rows
        blobs = accept(rows, self.config)
        self.dropped += len(rows) - len(blobs.rows)
        return blobs

    def _expect(self, dt: float, blobs: Blobs) -> Prediction:
        """Predict all tracks by dt [s]."""
        config, learned, tracks = self.config, self._adaptation, self._tracks
        learned.learn_size(blobs.z, config.image_size)
        if dt > 0 and len(tracks.records) and not learned.has_met:
            learned.meet(tracks.filters.mean[0, :, :2], blobs.z, dt)
            tracks.filters.set_speed(config.initial_speed or learned.speed)
        noise = config.process_noise or learned.noise
        tracks.filters.predict(dt, noise**2)
        records = tracks.records
        records['visible'], records['hidden'] = predict_existence(
            records['visible'], records['hidden'], dt, config.max_time_since_update
        )
        mean, cov = tracks.filters.estimate()
        seen = config.detection_probability * tracks.records['visible']
        unmeasured = tracks.unmeasured(self._clock.now)
        sized = config.use_boxes and bool(blobs.size.any() or tracks.records['extent'].any())
        return Prediction(
            bank=tracks.filters,
            records=tracks.records,
            center=mean[:, :2],
            velocity=mean[:, 2:4],
            variance=cov[:, [0, 1], [0, 1]],
            unmeasured=unmeasured,
            chance=learned.chance(unmeasured, self._period) * config.maneuvers,
            odds=np.log(seen / (1 - seen)),
            noise=noise,
            speed=config.initial_speed or learned.speed,
            density=math.log(config.clutter_density or learned.density),
            sized=sized,
        )

    def _associate(self, outlook: Prediction, blobs: Blobs) -> tuple[Hypotheses, Floats]:
        """Choose pairs by their likelihood against misses and clutter."""
        pairs = outlook.pair(blobs, *outlook.candidates(blobs, self.config))
        gain = pairs.innovations.log_likelihood - outlook.density + outlook.odds[pairs.track]
        if not self.config.color_gating:
            colors = self._tracks.records['color'][pairs.track], blobs.rows['color'][pairs.blob]
            gain -= MISTAKEN * (colors[0] != colors[1])
        if not self.config.gating:
            gain -= gain.min(initial=0.0) - 1.0
        associate = ASSOCIATORS[self.config.associator]
        chosen, share = associate(pairs.track, pairs.blob, gain)
        return pairs if len(chosen) == len(pairs) else pairs.take(chosen), share

    def _regroup(
        self,
        outlook: Prediction,
        blobs: Blobs,
        pairs: Hypotheses,
        share: Floats,
        free: NDArray[np.bool_],
    ) -> tuple[Blobs, Hypotheses, Floats]:
        """Join the pieces of broken blobs, and let tracks that merged share a blob.

        :param free: (M,) blobs that no track has taken; pieces are no longer free.
        """
        if not outlook.sized:
            return blobs, pairs, share
        taken = np.where(outlook.unmeasured > 0, -1, -2)
        taken[pairs.track[share > 0.5]] = pairs.blob[share > 0.5]
        piece, whole = merge_split.pieces(self._tracks.records, blobs, taken, np.flatnonzero(free))
        guest, host = merge_split.guests(self._tracks.records, outlook.center, blobs, taken)
        if not len(piece) and not len(guest):
            return blobs, pairs, share
        free[piece] = False
        blobs = shape.join(blobs, piece, whole)
        track, blob = np.append(pairs.track, guest), np.append(pairs.blob, host)
        share = np.append(share, np.ones(len(guest)))
        order = np.argsort(track, kind='stable')
        track, blob, share = track[order], blob[order], share[order]
        return blobs, outlook.pair(blobs, track, blob, np.isin(blob, host)), share

    def _correct(
        self, outlook: Prediction, blobs: Blobs, pairs: Hypotheses, share: Floats, again: bool
    ) -> None:
        """Update filters, existence, sizes and what is learned by what has been measured."""
        p = self.config.detection_probability
        ratio = np.full(len(self._tracks.records), 1.0 if again else 1 - p)
        likelihood = p * np.exp(
            np.minimum(pairs.innovations.log_likelihood - outlook.density, 50.0)
        )
        ratio += np.bincount(pairs.track, likelihood, len(ratio))
        records = self._tracks.records
        records['visible'], records['hidden'] = update_existence(
            records['visible'], records['hidden'], ratio
        )

        hard = bool((share == 1).all())
        taken = pairs if hard else pairs.take(np.flatnonzero(share > 0.5))
        track, blob = taken.track, taken.blob
        whole = self._learn_sizes(outlook, blobs, track, blob)
        self._adapt(outlook, taken, whole)
        turned = np.flatnonzero(taken.innovations.maneuvered > UNLIKELY)
        if len(turned):
            T = outlook.unmeasured[track[turned]]
            self._tracks.filters.maneuver(
                track[turned], taken.innovations.maneuvered[turned], T, outlook.speed
            )
        self._tracks.filters.correct(pairs.track, pairs.z, pairs.R, None if hard else share)
        self._tracks.records['misses'] += not again
        self._tracks.records['misses'][track] -= 1
        self._tracks.record_hits(track, self._clock.now)
        life.record_size(records, track, blobs.rows[blob])

    def _learn_sizes(
        self, outlook: Prediction, blobs: Blobs, track: Indices, blob: Indices
    ) -> NDArray[np.bool_]:
        """Learn sizes from blobs that tracks have for themselves; return (K,) which are whole.

        While an object grows into view its centroid moves at half its speed.
        """
        if not outlook.sized:
            return np.ones(len(track), bool)
        extent = self._tracks.records['extent'][track]
        alone = (np.bincount(blob, minlength=1)[blob] == 1) & ~blobs.joined[blob]
        size = extent.sum(axis=1)
        whole = alone & ~shape.difference(size, blobs.size[blob]).any(axis=1)
        last = np.stack(
            [self._tracks.records['box_w'][track], self._tracks.records['box_h'][track]], axis=1
        )
        learned = shape.learn(
            extent, blobs.z[blob], blobs.box[blob], outlook.center[track], last, self._period
        )
        learned[~alone] = extent[~alone]
        self._tracks.records['extent'][track] = learned
        self._tracks.records['partial'][track] &= blobs.cut[blob] | ~whole[:, None]
        growth = learned.sum(axis=1) - size
        growth[growth < shape.slack(size)] = 0.0
        if growth.any():
            self._tracks.filters.doubt_velocity(track, (growth / 2 / self._period) ** 2)
        return whole

    def _adapt(self, outlook: Prediction, taken: Hypotheses, whole: NDArray[np.bool_]) -> None:
        """Learn from objects seen whole in this frame and in the last."""
        records, track = self._tracks.records, taken.track
        before, unmeasured = records['innovation'][track], outlook.unmeasured[track]
        records['innovation'][track] = whole[:, None] * taken.innovations.innovation
        known = records['hits'][track] > 2
        self._adaptation.learn_rates(known, taken.innovations.maneuvered, unmeasured, self._period)
        steady = known & (unmeasured <= self._period) & whole
        product = np.einsum('ij,ij->i', before, taken.innovations.innovation)
        velocity = outlook.velocity[track]
        self._adaptation.learn_motion(
            steady,
            taken.innovations.nis,
            product,
            taken.innovations.predicted_share,
            taken.innovations.maneuvered,
            velocity,
        )

    def _settle(self, again: bool) -> None:
        """Let tracks be confirmed, coast, or end."""
        records, config = self._tracks.records, self.config
        before = records['state'].copy()
        keep = life.settle(self._tracks, self._clock.now, config)
        false = int(np.count_nonzero(~keep & (before == TENTATIVE)))
        estimate = self._tracks.filters.estimate()
        keep &= life.present(records, *estimate, self._clock.now, self._period, config)
        found = np.flatnonzero(keep & (before == TENTATIVE) & (records['state'] == CONFIRMED))
        lost = np.flatnonzero(keep & (records['state'] == COASTING))
        if len(found) and len(lost):
            lost, again_found = reunions(
                self._tracks, lost, found, self._clock.now, self._period, self._adaptation, config
            )
            life.succeed(self._tracks, lost, again_found)
            keep[again_found] = False
        if not again:
            self._adaptation.learn_new(false, int(np.count_nonzero(keep[found])))
        if not keep.all():
            self._tracks.keep(keep)
