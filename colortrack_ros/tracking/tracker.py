"""The tracker: detections of one frame in, tracks out."""

import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.tracking import blobs
from colortrack_ros.tracking import life
from colortrack_ros.tracking.association import ASSOCIATORS
from colortrack_ros.tracking.bank import Bank
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.gating import candidates
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
        self._why = ''
        self.reset()

    def reset(self) -> None:
        """Forget all tracks. IDs go on: none is used twice."""
        self._stamp: int | None = None
        self._bank = Bank(MOTION_MODELS[self.config.motion_model]())
        self._records = np.zeros(0, life.RECORD)

    def configure(self, config: TrackerConfig) -> None:
        """Change the configuration; tracks live on, unless the motion model is another."""
        old, self.config = self.config, config
        if old.motion_model != config.motion_model:
            self.reset()
            self._why = f'motion_model changed from {old.motion_model} to {config.motion_model}'

    def update(self, detections: Detections) -> Tracks:
        """Take the detections of one frame.

        :param detections: of the next frame; an empty one is a frame as well.
        :return: the tracks at its stamp, with its header.
        """
        dt = self._advance(detections.stamp)
        rows, z, R = self._accept(detections.rows)
        track, detection, z_pair, R_pair = self._associate(rows, z, R)
        self._bank.correct(track, z_pair, R_pair)
        life.hit(self._records, track, rows[detection], detections.stamp)
        self._learn(track, rows[detection], dt)
        self._spawn(rows, z, R, detection)
        keep = life.settle(self._records, detections.stamp, self.config)
        self._bank.keep(keep)
        self._records = self._records[keep]
        why, self._why = self._why, ''
        return Tracks(self._rows(), detections.stamp, detections.frame_id, why)

    def _advance(self, stamp: int) -> float:
        """Predict to the stamp, or start afresh; return dt [s]."""
        dt = 0.0 if self._stamp is None else (stamp - self._stamp) / NANOSECONDS
        if dt < 0:
            self._why = f'the stamp went back by {-dt:.6f} s'
        elif dt > self.config.max_dt:
            self._why = f'the stamp jumped ahead by {dt:.6f} s, max_dt is {self.config.max_dt:g} s'
        if not 0 <= dt <= self.config.max_dt:
            self.reset()
            dt = 0.0
        self._stamp = stamp
        self._bank.predict(dt, self.config.process_noise**2)
        life.conceal(self._records, dt, self.config)
        return dt

    def _accept(self, rows: NDArray[np.void]) -> tuple[NDArray[np.void], Floats, Floats]:
        """Drop and count bad rows; return the others, (M,), their z (M, 2) and R (M, 2, 2)."""
        names = ('u', 'v', 'cov_uu', 'cov_uv', 'cov_vv', 'area', 'box_u', 'box_v', 'box_w', 'box_h')
        finite = np.isfinite([rows[name] for name in names]).all(axis=0)
        a, b, c = rows['cov_uu'], rows['cov_uv'], rows['cov_vv']
        none = (a == 0) & (b == 0) & (c == 0)
        with np.errstate(invalid='ignore', over='ignore'):
            positive = (a > 0) & (c > 0) & (a * c > b * b)
        good = finite & (none | positive)
        self.dropped += int(len(rows) - np.count_nonzero(good))
        rows, none = rows[good], none[good]
        z = np.stack([rows['u'], rows['v']], axis=1)
        R = np.empty((len(rows), 2, 2))
        R[:, 0, 0], R[:, 1, 1] = rows['cov_uu'], rows['cov_vv']
        R[:, 0, 1] = R[:, 1, 0] = rows['cov_uv']
        if not self.config.detection_covariance:
            none[:] = True
        R[none] = self.config.measurement_noise**2 * np.eye(2)
        return rows, z, R

    def _associate(
        self, rows: NDArray[np.void], z: Floats, R: Floats
    ) -> tuple[Indices, Indices, Floats, Floats]:
        """Choose pairs of tracks and detections, and settle what each exists by.

        :return: (K,) tracks, ascending, (K,) detections, and what they measure, z and R.
        """
        seen = self.config.detection_probability * self._records['visible']
        track, detection = self._candidates(rows, z, R)
        z, R = self._measure(track, rows[detection], z[detection], R[detection])
        ratio = self._bank.log_likelihood(track, z, R) - self._log_density
        gain = ratio + np.log(seen / (1 - seen))[track]
        likely = np.flatnonzero(gain > 0)
        chosen = ASSOCIATORS[self.config.associator](track[likely], detection[likely], gain[likely])
        pair = likely[chosen]
        found = np.zeros(len(self._records))
        found[track[pair]] = np.exp(np.minimum(ratio[pair], 50.0))
        p = self.config.detection_probability
        life.reveal(self._records, 1 - p + p * found)
        missed = np.ones(len(self._records), bool)
        missed[track[pair]] = False
        self._records['misses'] += missed
        return track[pair], detection[pair], z[pair], R[pair]

    @property
    def _log_density(self) -> float:
        """Log of the clutter density; without clutter every pair is worth more than a miss."""
        return math.log(self.config.clutter_density) if self.config.clutter_density else -1e9

    def _candidates(self, rows: NDArray[np.void], z: Floats, R: Floats) -> tuple[Indices, Indices]:
        """All pairs whose gain may be positive: d^2 below a bound that S sets, and of a color."""
        S = self._bank.cov[:, :2, :2]
        widest = R.max(axis=0, initial=0.0)
        p = self.config.detection_probability
        log_det = np.log(4 * np.pi**2 * np.linalg.det(S + R.min(axis=0, initial=0.0)))
        bound = 2 * (math.log(p / (1 - p)) - self._log_density) - log_det
        bound = np.maximum(bound, 0.0)[:, None]
        half = np.sqrt(bound * (np.diagonal(S, axis1=1, axis2=2) + np.diag(widest)))
        if self.config.use_boxes:
            half = half + self._records['extent'].sum(axis=1) / 2
        track, detection = candidates(self._bank.mean[:, :2], half, z)
        if self.config.color_gating:
            same = self._records['color'][track] == rows['color'][detection]
            track, detection = track[same], detection[same]
        return track, detection

    def _measure(
        self, track: Indices, rows: NDArray[np.void], z: Floats, R: Floats
    ) -> tuple[Floats, Floats]:
        """What each detection of a pair measures, seen from its track."""
        if not self.config.use_boxes:
            return z, R
        return blobs.measure(
            z,
            R,
            blobs.sides(rows),
            self._records['extent'][track],
            self._bank.mean[track, :2],
            np.diagonal(self._bank.cov[track, :2, :2], axis1=1, axis2=2),
        )

    def _learn(self, track: Indices, rows: NDArray[np.void], dt: float) -> None:
        extent = self._records['extent']
        extent[track] = blobs.learn(extent[track], blobs.reach(rows), dt)

    def _spawn(self, rows: NDArray[np.void], z: Floats, R: Floats, taken: Indices) -> None:
        """Start a track on each detection left, unless it is a piece of a known object."""
        new = np.ones(len(rows), bool)
        new[taken] = False
        if self.config.use_boxes:
            known = self._records['state'] != TENTATIVE
            half = self._records['extent'][known].sum(axis=1) / 2
            owner, piece = candidates(self._bank.mean[known, :2], half, z)
            same = self._records['color'][known][owner] == rows['color'][piece]
            new[piece[same]] = False
        self._bank.append(z[new], R[new], self.config.initial_speed)
        born = life.births(rows[new], self._stamp or 0, self._next_id)
        self._next_id += len(born)
        self._records = np.concatenate([self._records, born])

    def _rows(self) -> NDArray[np.void]:
        rows, records = np.zeros(len(self._records), TRACK), self._records
        for name in ('track_id', 'color', 'state', 'hits', 'area', 'box_w', 'box_h'):
            rows[name] = records[name]
        rows['u'], rows['v'], rows['du'], rows['dv'] = self._bank.mean[:, :4].T
        rows['covariance'] = self._bank.cov[:, :4, :4]
        stamp = self._stamp or 0
        rows['age'] = (stamp - records['born']) / NANOSECONDS
        rows['time_since_update'] = (stamp - records['updated']) / NANOSECONDS
        rows['score'] = records['visible'] + records['hidden']
        return rows
