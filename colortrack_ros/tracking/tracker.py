"""The tracker: detections of one frame in, tracks out."""

import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.tracking import blobs as shape
from colortrack_ros.tracking import life
from colortrack_ros.tracking import merged
from colortrack_ros.tracking import regroup
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.association import ASSOCIATORS
from colortrack_ros.tracking.association.gnn import associate as gnn
from colortrack_ros.tracking.bank import Bank
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.gating import candidates
from colortrack_ros.tracking.intake import accept
from colortrack_ros.tracking.intake import Blobs
from colortrack_ros.tracking.motion import MOTION_MODELS
from colortrack_ros.tracking.pairs import Pairs

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

FAR = 1e9
"""Half width of a gate that is none [px]."""

UNLIKELY = 1e-3
"""A maneuver of less probability is left out of account."""


class Tracker:
    """Many objects, one Kalman filter each (Pegoretti 2021, 3.1.2, its faults mended).

    :param config: see TrackerConfig.
    """

    def __init__(self, config: TrackerConfig | None = None) -> None:
        self.config = config or TrackerConfig()
        self.dropped = 0
        """Detections refused so far: not finite, or with a covariance that is none."""
        self._next_id = 1
        self.reset()

    def reset(self, why: str = '') -> None:
        """Forget all tracks. IDs go on: none is used twice.

        :param why: what the next Tracks tell as the reason.
        """
        self._why = why
        self._stamp: int | None = None
        self._bank = Bank(MOTION_MODELS[self.config.motion_model](self.config.acceleration))
        self._records = np.zeros(0, life.RECORD)
        self._adaptation = Adaptation()

    def configure(self, config: TrackerConfig) -> None:
        """Change the configuration; tracks live on, unless the motion model is another."""
        old, self.config = self.config, config
        if old.motion_model != config.motion_model:
            self.reset(f'motion_model changed from {old.motion_model} to {config.motion_model}')

    def update(self, detections: Detections) -> Tracks:
        """Take the detections of one frame.

        :param detections: of the next frame; an empty one is a frame as well.
        :return: the tracks at its stamp, with its header.
        """
        dt = self._advance(detections.stamp)
        blobs = accept(detections.rows, self.config)
        self.dropped += len(detections.rows) - len(blobs.rows)
        self._adaptation.learn_size(blobs.z, self.config.image_size)
        self._log_density = math.log(self.config.clutter_density or self._adaptation.density)
        pairs, share = self._associate(blobs)
        free = np.ones(len(blobs.rows), bool)
        free[pairs.blob[share > 0.5]] = False
        blobs, pairs, share = self._regroup(blobs, pairs, share, free)
        self._correct(blobs, pairs, share, dt)
        self._spawn(blobs, np.flatnonzero(free))
        self._settle(dt)
        why, self._why = self._why, ''
        return Tracks(self._rows(), detections.stamp, detections.frame_id, why)

    def _advance(self, stamp: int) -> float:
        """Predict to the stamp, or start afresh; return dt [s]."""
        dt = 0.0 if self._stamp is None else (stamp - self._stamp) / NANOSECONDS
        if dt < 0:
            self.reset(f'the stamp went back by {-dt:.6f} s')
        elif dt > self.config.max_dt:
            self.reset(f'the stamp jumped ahead by {dt:.6f} s, max_dt is {self.config.max_dt:g} s')
        dt = 0.0 if self._stamp is None else dt
        self._stamp = self._now = stamp
        self._noise = self.config.process_noise or self._adaptation.noise
        self._speed = self.config.initial_speed or self._adaptation.speed
        self._bank.predict(dt, self._noise**2)
        mean, cov = self._bank.estimate()
        self._center, self._velocity = mean[:, :2], mean[:, 2:4]
        self._variance = cov[:, [0, 1], [0, 1]]
        life.conceal(self._records, dt, self.config)
        seen = self.config.detection_probability * self._records['visible']
        self._odds = np.log(seen / (1 - seen))
        self._unmeasured = (stamp - self._records['updated']) / NANOSECONDS
        self._chance = self._adaptation.chance(self._unmeasured, dt) * self.config.maneuvers
        return dt

    def _associate(self, blobs: Blobs) -> tuple[Pairs, Floats]:
        """Choose pairs by their likelihood against misses and clutter."""
        pairs = self._pair(blobs, *self._candidates(blobs))
        gain = pairs.likelihood - self._log_density + self._odds[pairs.track]
        if not self.config.gating:
            gain -= gain.min(initial=0.0) - 1.0
        associate = ASSOCIATORS[self.config.associator]
        chosen, share = associate(pairs.track, pairs.blob, gain)
        return pairs.take(chosen), share

    def _candidates(self, blobs: Blobs) -> tuple[Indices, Indices]:
        """All pairs whose gain may be positive: d^2 below a bound that S sets, and of a color.

        The rectangle holds the gates of going on and of having maneuvered.
        """
        R = blobs.R[:, [0, 1], [0, 1]]
        widest, narrowest = R.max(axis=0, initial=0.0), R.min(axis=0, initial=1e9) + 1e-9
        T = self._unmeasured[:, None]
        way = self._velocity * T / 2
        variance = np.array(
            [self._variance, self._variance + way**2 / 3 + (self._speed * T) ** 2 / 3]
        )
        weight = np.array([np.ones_like(self._chance), np.maximum(self._chance, 1e-100)])
        S = variance + narrowest
        limit = 2 * (self._odds - self._log_density - math.log(np.pi))
        bound = limit + np.log(weight**2 / (S[..., 0] * S[..., 1]))
        half = np.sqrt(np.maximum(bound, 0.0)[..., None] * (variance + widest))
        if not self.config.gating:
            half[:] = FAR
        half += self._records['extent'].sum(axis=1) / 2
        low = np.minimum(-half[0], -way - half[1])
        high = np.maximum(half[0], half[1] - way)
        track, blob = candidates(self._center + (low + high) / 2, (high - low) / 2, blobs.z)
        if self.config.color_gating:
            same = self._records['color'][track] == blobs.rows['color'][blob]
            track, blob = track[same], blob[same]
        return track, blob

    def _pair(
        self, blobs: Blobs, track: Indices, blob: Indices, shared: NDArray[np.bool_] | None = None
    ) -> Pairs:
        """Compare pairs.

        :param shared: (K,) pairs whose blob is shared by several tracks.
        """
        z, R = blobs.z[blob], blobs.R[blob]
        extent = self._records['extent'][track]
        if extent.any():
            prediction = self._center[track], self._variance[track]
            center = shape.centers(z, blobs.box[blob], extent)
            weight = shape.sides_of_one(center, *prediction)
            if shared is not None and shared.any():
                one = np.flatnonzero(shared)
                several = (part[one] for part in prediction)
                weight[:, one] = merged.sides_of_several(blobs, blob[one], center[:, one], *several)
            z, R = shape.measure(blobs, blob, extent, weight)
        compared = self._bank.compare(
            track, z, R, self._chance[track], self._unmeasured[track], self._speed
        )
        return Pairs(track, blob, z, R, *compared)

    def _regroup(
        self, blobs: Blobs, pairs: Pairs, share: Floats, free: NDArray[np.bool_]
    ) -> tuple[Blobs, Pairs, Floats]:
        """Join the pieces of broken blobs, and let tracks that merged share a blob.

        :param free: (M,) blobs that no track has taken; pieces are no longer free.
        """
        if not self._records['extent'].any():
            return blobs, pairs, share
        taken = np.full(len(self._records), -1)
        taken[pairs.track[share > 0.5]] = pairs.blob[share > 0.5]
        piece, whole = regroup.pieces(self._records, blobs, taken, np.flatnonzero(free))
        guest, host = regroup.guests(self._records, self._center, blobs, taken)
        if not len(piece) and not len(guest):
            return blobs, pairs, share
        free[piece] = False
        blobs = shape.join(blobs, piece, whole)
        track, blob = np.append(pairs.track, guest), np.append(pairs.blob, host)
        share = np.append(share, np.ones(len(guest)))
        order = np.argsort(track, kind='stable')
        track, blob, share = track[order], blob[order], share[order]
        return blobs, self._pair(blobs, track, blob, np.isin(blob, host)), share

    def _correct(self, blobs: Blobs, pairs: Pairs, share: Floats, dt: float) -> None:
        """Update filters, existence, sizes and what is learned by what has been measured."""
        p = self.config.detection_probability
        ratio = np.full(len(self._records), 1 - p)
        likelihood = np.exp(np.minimum(pairs.likelihood - self._log_density, 50.0))
        np.add.at(ratio, pairs.track, p * likelihood)
        life.reveal(self._records, ratio)

        hard = bool((share == 1).all())
        taken = pairs if hard else pairs.take(np.flatnonzero(share > 0.5))
        track, blob = taken.track, taken.blob
        whole = self._learn_sizes(blobs, track, blob, dt)
        self._adapt(taken, whole, dt)
        turned = np.flatnonzero(taken.turned > UNLIKELY)
        if len(turned):
            T = self._unmeasured[track[turned]]
            self._bank.maneuver(track[turned], taken.turned[turned], T, self._speed)
        self._bank.correct(pairs.track, pairs.z, pairs.R, None if hard else share)
        self._records['misses'] += 1
        self._records['misses'][track] -= 1
        life.hit(self._records, track, blobs.rows[blob], self._now)

    def _learn_sizes(
        self, blobs: Blobs, track: Indices, blob: Indices, dt: float
    ) -> NDArray[np.bool_]:
        """Learn sizes from blobs that tracks have for themselves; return (K,) which are whole.

        While an object grows into view its centroid moves at half its speed.
        """
        extent = self._records['extent'][track]
        if not extent.any() and not blobs.size.any():
            return np.ones(len(track), bool)
        alone = (np.bincount(blob, minlength=1)[blob] == 1) & ~blobs.joined[blob]
        size = extent.sum(axis=1)
        whole = alone & ~shape.difference(size, blobs.size[blob]).any(axis=1)
        last = np.stack([self._records['box_w'][track], self._records['box_h'][track]], axis=1)
        learned = shape.learn(extent, blobs.z[blob], blobs.box[blob], self._center[track], last, dt)
        learned[~alone] = extent[~alone]
        self._records['extent'][track] = learned
        growth = learned.sum(axis=1) - size
        growth[growth < shape.slack(size)] = 0.0
        if dt > 0 and growth.any():
            self._bank.cov[:, track[:, None], (2, 3), (2, 3)] += (growth / 2 / dt) ** 2
        return whole

    def _adapt(self, taken: Pairs, whole: NDArray[np.bool_], dt: float) -> None:
        """Learn from objects seen whole in this frame and in the last."""
        records, track = self._records, taken.track
        before = records['innovation'][track]
        records['innovation'][track] = whole[:, None] * taken.innovation
        steady = (records['hits'][track] > 2) & (self._unmeasured[track] <= dt) & whole
        product = (before * taken.innovation).sum(axis=1)
        velocity = self._bank.mean[0, track[steady], 2:4]
        self._adaptation.learn_motion(
            taken.nis[steady],
            product[steady],
            taken.predicted[steady],
            taken.turned[steady],
            velocity,
        )
        known = records['hits'][track] > 2
        self._adaptation.learn_rates(taken.turned[known], self._unmeasured[track[known]], dt)

    def _spawn(self, blobs: Blobs, free: Indices) -> None:
        """Start a track on each blob left."""
        if not len(free):
            return
        spread = np.repeat([0.0, self._speed, self._noise], 2)[: self._bank.model.size]
        self._bank.append(blobs.z[free], blobs.R[free], spread)
        born = life.births(blobs, free, self._now, self._next_id)
        self._next_id += len(born)
        self._records = np.concatenate([self._records, born], dtype=life.RECORD)

    def _settle(self, dt: float) -> None:
        """Let tracks be confirmed, coast, or end."""
        before = self._records['state'].copy()
        keep = life.settle(self._records, self._now, self.config)
        false = int(np.count_nonzero(~keep & (before == TENTATIVE)))
        self._adaptation.learn_false(false)
        keep &= life.present(self._records, *self._bank.estimate(), self._now, dt, self.config)
        found = np.flatnonzero(keep & (before == TENTATIVE) & (self._records['state'] == CONFIRMED))
        lost = np.flatnonzero(keep & (self._records['state'] == COASTING))
        reunited = self._reunite(lost, found, dt) if len(found) and len(lost) else found[:0]
        keep[reunited] = False
        self._adaptation.learn_births(len(found) - len(reunited))
        if not keep.all():
            self._bank.keep(keep)
            self._records = self._records[keep]

    def _reunite(self, lost: Indices, found: Indices, dt: float) -> Indices:
        """Tracks just confirmed that are what has become of coasting ones take their places.

        What a single detection could not decide, the first few do: they are no clutter, and have a
        velocity.

        :return: the indices of those that have taken another's place.
        """
        records = self._records
        pair = np.indices((len(lost), len(found))).reshape(2, -1)
        one, other = lost[pair[0]], found[pair[1]]
        T = (self._now - records['updated'][one]) / NANOSECONDS
        fit = (records['born'][other] > records['updated'][one]) & (
            records['color'][one] == records['color'][other]
        )
        chance = self._adaptation.chance(T, dt) * self.config.maneuvers
        gain = self._bank.resemblance(one, other, chance, T, self._speed)
        gain += np.log(np.maximum(records['hidden'][one], 1e-9))
        gain -= np.log(
            self._adaptation.birth_density(records['origin'][other], self.config.image_size)
        )
        gain[~fit] = -1.0
        chosen, _ = gnn(one, other, gain)
        one, other = one[chosen], other[chosen]
        self._bank.succeed(one, other)
        life.succeed(records, one, other)
        return other

    def _rows(self) -> NDArray[np.void]:
        """Return the tracks as they are published; none that is outside the picture."""
        inside = ~self._records['outside']
        records = self._records if inside.all() else self._records[inside]
        rows = np.zeros(len(records), TRACK)
        for name in ('track_id', 'color', 'state', 'hits', 'area', 'box_w', 'box_h'):
            rows[name] = records[name]
        mean, covariance = self._bank.estimate()
        rows['u'], rows['v'], rows['du'], rows['dv'] = mean[inside, :4].T
        rows['covariance'] = covariance[inside, :4, :4]
        rows['covariance'][:, [0, 1], [0, 1]] += self.config.centroid_bias**2
        rows['age'] = (self._now - records['born']) / NANOSECONDS
        rows['time_since_update'] = (self._now - records['updated']) / NANOSECONDS
        rows['score'] = records['visible'] + records['hidden']
        return rows
