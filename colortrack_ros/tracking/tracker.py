"""The tracker: detections of one frame in, tracks out."""

import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.tracking import blobs as shape
from colortrack_ros.tracking import life
from colortrack_ros.tracking import regroup
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.association import ASSOCIATORS
from colortrack_ros.tracking.bank import Bank
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.gating import candidates
from colortrack_ros.tracking.intake import accept
from colortrack_ros.tracking.intake import Blobs
from colortrack_ros.tracking.motion import MOTION_MODELS

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


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
        self._adaptation = Adaptation()
        self._records = np.zeros(0, life.RECORD)

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
        track, blob = self._associate(blobs)
        free = np.setdiff1d(np.arange(len(blobs.rows)), blob)
        blobs, free, track, blob = self._regroup(blobs, free, track, blob)
        self._correct(blobs, track, blob, dt)
        self._spawn(blobs, free)
        keep = life.settle(self._records, detections.stamp, self.config)
        self._bank.keep(keep)
        self._records = self._records[keep]
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
        self._stamp = stamp
        self._bank.predict(dt, self._noise**2)
        self._center, self._variance = (part[:, :2] for part in self._bank.estimate())
        self._variance = np.diagonal(self._variance, axis1=1, axis2=2)
        life.conceal(self._records, dt, self.config)
        return dt

    @property
    def _now(self) -> int:
        return self._stamp or 0

    @property
    def _noise(self) -> float:
        return self.config.process_noise or self._adaptation.noise

    @property
    def _speed(self) -> float:
        return self.config.initial_speed or self._adaptation.speed

    @property
    def _log_density(self) -> float:
        """Log of the clutter density; without clutter every pair is worth more than a miss."""
        return math.log(self.config.clutter_density) if self.config.clutter_density else -1e9

    def _associate(self, blobs: Blobs) -> tuple[Indices, Indices]:
        """Choose the pairs of greatest likelihood against misses and clutter."""
        track, blob = self._candidates(blobs)
        likelihood, _ = self._likelihood(track, *self._measure(blobs, track, blob))
        seen = self.config.detection_probability * self._records['visible']
        gain = likelihood - self._log_density + np.log(seen / (1 - seen))[track]
        likely = np.flatnonzero(gain > 0)
        associate = ASSOCIATORS[self.config.associator]
        chosen = likely[associate(track[likely], blob[likely], gain[likely])]
        return track[chosen], blob[chosen]

    def _maneuver(self) -> tuple[Floats, Floats]:
        """Probability that each track has changed its velocity since it was last measured.

        At any time T since then alike, so that its position has got sigma^2 T^2 / 3.

        :return: (N,), and T (N,) [s].
        """
        T = (self._now - self._records['updated']) / NANOSECONDS
        return -np.expm1(-self._adaptation.rate * self.config.maneuvers * T), T

    def _likelihood(self, track: Indices, z: Floats, R: Floats) -> tuple[Floats, Floats]:
        """Log likelihood of pairs, (K,), and the probability that it takes a maneuver, (K,)."""
        p, T = self._maneuver()
        wide = R + (self._speed**2 * T[track] ** 2 / 3)[:, None, None] * np.eye(2)
        steady = np.logaddexp.reduce(self._bank.log_likelihoods(track, z, R), axis=0)
        turned = np.logaddexp.reduce(self._bank.log_likelihoods(track, z, wide), axis=0)
        with np.errstate(divide='ignore'):
            steady, turned = np.log1p(-p[track]) + steady, np.log(p[track]) + turned
        total = np.logaddexp(steady, turned)
        return total, np.exp(turned - total)

    def _measure(
        self, blobs: Blobs, track: Indices, blob: Indices, shared: NDArray[np.bool_] | None = None
    ) -> tuple[Floats, Floats]:
        """What each blob measures of its track: z (K, 2) and R (K, 2, 2).

        :param shared: (K,) pairs whose blob is shared by several tracks.
        """
        extent = self._records['extent'][track]
        if not extent.any():
            return blobs.z[blob], blobs.R[blob]
        prediction = self._center[track], self._variance[track]
        center = shape.centers(blobs.z[blob], blobs.box[blob], extent)
        weight = shape.sides_of_one(center, *prediction)
        if shared is not None and shared.any():
            several = [part[shared] for part in prediction]
            weight[:, shared] = shape.sides_of_several(blob[shared], *several)
        return shape.measure(blobs, blob, extent, weight)

    def _candidates(self, blobs: Blobs) -> tuple[Indices, Indices]:
        """All pairs whose gain may be positive: d^2 below a bound that S sets, and of a color."""
        p = self.config.detection_probability
        limit = 2 * (math.log(2 * p / (1 - p)) - self._log_density - math.log(2 * np.pi))
        R = np.diagonal(blobs.R, axis1=1, axis2=2)
        widest, narrowest = R.max(axis=0, initial=0.0), R.min(axis=0, initial=1e9)
        half = np.zeros_like(self._center)
        chance, T = self._maneuver()
        jump = (self._speed * T)[:, None] ** 2 / 3
        with np.errstate(divide='ignore'):
            for weight, variance in (
                (1.0, self._variance),
                (chance, self._variance + jump),
            ):
                bound = limit + 2 * np.log(weight) - np.log((variance + narrowest).prod(axis=1))
                bound = np.maximum(bound, 0.0)[:, None]
                half = np.maximum(half, np.sqrt(bound * (variance + widest)))
        half += self._records['extent'].sum(axis=1) / 2
        track, blob = candidates(self._center, half, blobs.z)
        if self.config.color_gating:
            same = self._records['color'][track] == blobs.rows['color'][blob]
            track, blob = track[same], blob[same]
        return track, blob

    def _regroup(
        self, blobs: Blobs, free: Indices, track: Indices, blob: Indices
    ) -> tuple[Blobs, Indices, Indices, Indices]:
        """Join the pieces of broken blobs, and let tracks that merged share a blob."""
        if not self._records['extent'].any():
            return blobs, free, track, blob
        taken = np.full(len(self._records), -1)
        taken[track] = blob
        piece, whole = regroup.pieces(self._records, blobs, taken, free)
        blobs = shape.join(blobs, piece, whole)
        free = np.setdiff1d(free, piece)
        guest, host = regroup.guests(self._records, self._center, blobs, taken)
        return blobs, free, np.append(track, guest), np.append(blob, host)

    def _correct(self, blobs: Blobs, track: Indices, blob: Indices, dt: float) -> None:
        """Update filters, existence and sizes with what has been measured."""
        shared = np.bincount(blob, minlength=1)[blob] > 1
        z, R = self._measure(blobs, track, blob, shared)
        likelihood, turned = self._likelihood(track, z, R)
        p = self.config.detection_probability
        ratio = np.full(len(self._records), 1 - p)
        ratio[track] += p * np.exp(np.minimum(likelihood - self._log_density, 50.0))
        life.reveal(self._records, ratio)
        single = np.flatnonzero(~shared)
        size = self._records['extent'][track].sum(axis=1)
        whole = ~shared & ~shape.difference(size, blobs.size[blob]).any(axis=1)
        self._learn(track[single], blobs.z[blob[single]], blobs.box[blob[single]], dt)
        last = self._records['updated'][track] >= self._now - round(dt * NANOSECONDS)
        e, weighted = self._bank.innovation(track, z, R)
        before = self._records['innovation'][track]
        self._records['innovation'][track] = whole[:, None] * e
        self._bank.kick(track, turned * self._speed**2, self._maneuver()[1][track])
        self._bank.correct(track, z, R, np.ones(len(track)))
        old = (self._records['hits'][track] > 2) & last & whole
        velocity = self._bank.estimate()[0][track[old], 2:4]
        nis, product = (e * weighted).sum(axis=1), (before * weighted).sum(axis=1)
        self._adaptation.learn(nis[old], product[old], turned[old], velocity, dt)
        self._records['misses'] += 1
        self._records['misses'][track] -= 1
        life.hit(self._records, track, blobs.rows[blob], self._now)

    def _learn(self, track: Indices, z: Floats, box: Floats, dt: float) -> None:
        """Learn sizes. While an object grows into view its centroid moves at half its speed."""
        extent = self._records['extent'][track]
        learned = shape.learn(extent, z, box, self._center[track], dt)
        self._records['extent'][track] = learned
        growth = (learned - extent).sum(axis=1)
        growth[growth < shape.slack(extent.sum(axis=1))] = 0.0
        if dt > 0 and growth.any():
            self._bank.cov[:, track[:, None], (2, 3), (2, 3)] += (growth / 2 / dt) ** 2

    def _spawn(self, blobs: Blobs, free: Indices) -> None:
        """Start a track on each blob left."""
        spread = np.repeat([0.0, self._speed, self._noise], 2)[: self._bank.model.size]
        self._bank.append(blobs.z[free], blobs.R[free], spread)
        born = life.births(blobs, free, self._now, self._next_id)
        self._next_id += len(born)
        self._records = np.concatenate([self._records, born])

    def _rows(self) -> NDArray[np.void]:
        """Return the tracks as they are published."""
        rows, records = np.zeros(len(self._records), TRACK), self._records
        for name in ('track_id', 'color', 'state', 'hits', 'area', 'box_w', 'box_h'):
            rows[name] = records[name]
        mean, covariance = self._bank.estimate()
        rows['u'], rows['v'], rows['du'], rows['dv'] = mean[:, :4].T
        rows['covariance'] = covariance[:, :4, :4]
        rows['age'] = (self._now - records['born']) / NANOSECONDS
        rows['time_since_update'] = (self._now - records['updated']) / NANOSECONDS
        rows['score'] = records['visible'] + records['hidden']
        return rows
