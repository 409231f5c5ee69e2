"""Prediction: the expected state of each track in a frame, before its detections are used."""

from dataclasses import dataclass
from dataclasses import field
from functools import cached_property
import math
from typing import NamedTuple

import numpy as np

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.existence import predict_existence
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.adaptation import LEAST_SPEED
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.ego_motion import FEWEST
from colortrack_ros.tracking.ego_motion import find_ego_motion
from colortrack_ros.tracking.ego_motion import find_jump
from colortrack_ros.tracking.growth import grow
from colortrack_ros.tracking.maneuvers import maneuver_chance
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.measurements import median
from colortrack_ros.tracking.sizes import log_fit
from colortrack_ros.tracking.sizes import nearness
from colortrack_ros.tracking.sizes import Sizes
from colortrack_ros.tracking.sizes import total
from colortrack_ros.tracking.unsized import lend_sizes

LAST_FRAME = 1.5
"""A track measured within this many frames was measured in the last one; halfway from 1 to 2."""

LEAST_SIZE_SLACK = 0.15
"""Least tolerance of the size of whole boxes, as a share of it. Networks have few sizes to choose
from: a tenth of the boxes of three detectors differ by 0.17 to 0.19 from what was learned, most by
little, so that their typical change says less than what they may do. With 0.25, mean IDF1 of
three runs of MOT16-09 is 0.016 lower."""


class Step(NamedTuple):
    """From the last message to this one.

    :param now: stamp of the frame [ns].
    :param dt: since the stamp of the last message [s]; 0 if it is the same.
    :param period: since the last frame [s].
    :param again: whether there were detections of this stamp before.
    :param pauses: whether the detector usually finds nothing in this frame, see Rhythm.
    """

    now: int
    dt: float
    period: float
    again: bool
    pauses: bool = False


@dataclass
class Prediction:
    """N tracks, predicted.

    :param step: to the frame.
    :param bank: the filters.
    :param records: (N,) see records.FIELDS.
    :param center: (N, 2) predicted positions [px].
    :param velocity: (N, 2) [px/s].
    :param variance: (N, 2) of the positions [px^2].
    :param size: (N, 2) learned width and height [px], 0 where unknown.
    :param unseen: (N,) time since each was measured alone [s].
    :param unmeasured: (N,) time since each was measured, alone or with others [s].
    :param maneuvered: (N,) prior probability of a maneuver in that time.
    :param detection_probability: of a visible object.
    :param log_odds: (N,) log of the odds that each is detected in this frame.
    :param noise: standard deviation of the acceleration on each axis [px/s^2].
    :param speed: (2,) standard deviation of a new velocity on each axis [px/s].
    :param sudden_speed: the same for objects that start from rest all at once [px/s].
    :param log_density: log of the density of detections that belong to no track [1/px^2].
    :param sized: whether any track or blob has a size.
    :param sizes: statistics of sizes.
    :param finds_whole: see Adaptation.
    :param weak_below: see Overlaps.
    :ivar turn: (1, 2) as speed, for what maneuvers, or for each, (N, 2) [px/s].
    :ivar is_scaled: whether it is for each, by its nearness().
    """

    step: Step
    bank: Bank
    records: Records
    center: Floats
    velocity: Floats
    variance: Floats
    size: Floats
    unseen: Floats
    unmeasured: Floats
    maneuvered: Floats
    detection_probability: float
    log_odds: Floats
    noise: float
    speed: Floats
    sudden_speed: float
    log_density: float
    sized: bool
    sizes: Sizes
    finds_whole: bool
    weak_below: float
    turn: Floats = field(init=False)
    is_scaled: bool = field(init=False)

    def __post_init__(self) -> None:
        near = nearness(self.size) if self.finds_whole else None
        self.is_scaled = near is not None
        self.turn = self.speed[None] if near is None else near * self.speed

    @cached_property
    def slack(self) -> Floats:
        """(N, 2) tolerance of the size of a complete blob [px]."""
        slack = self.sizes.slack(self.size)
        return np.maximum(slack, LEAST_SIZE_SLACK * self.size) if self.finds_whole else slack

    @cached_property
    def best_fit(self) -> Floats:
        """(N,) log-likelihood ratio of a blob of exactly that size, see Sizes.log_fit()."""
        return self.sizes.most_fitting(self.size, self.slack)

    def turn_speed(self, track: Indices) -> Floats:
        """Standard deviation of the velocity after a maneuver, (1, 2), or of each, (K, 2)."""
        return self.turn.take(track, axis=0) if self.is_scaled else self.turn

    def log_fit(self, track: Indices, size: Floats) -> Floats:
        """Log-likelihood ratio of blobs' sizes, (K, 2) [px], for tracks, (K,): (K,)."""
        excess = size - self.size.take(track, axis=0)
        return log_fit(excess, self.slack.take(track, axis=0), self.best_fit[track])


def predict(
    tracks: TrackTable[Bank],
    measurements: Measurements,
    learned: Adaptation,
    config: TrackerConfig,
    step: Step,
) -> Prediction:
    """Predict filters and existence of all tracks.

    :param measurements: of the frame; only their spread, and whether they have sizes, is used.
    :param learned: of the scene; it learns the speed from the first two frames here.
    """
    bank, records, dt = tracks.filters, tracks.records, step.dt
    if not learned.has_met and dt > 0 and len(records):
        learned.meet(bank.mean[0, :, :2], measurements.z, dt)
        bank.set_speed(assumed_speed(learned, config))
    variance = process_variance(records, learned, config)
    learned.maneuvers.conclude(records, variance)
    if config.process_noise:
        records['astray'] = 0.0  # what is given holds, unseen as well
    bank.predict(dt, variance, known_acceleration(records, config))
    if config.ego_motion == 'detections' or learned.camera.is_watched:
        _follow_camera(tracks, measurements, learned, step, config)
    if dt > 0:
        learned.camera.carry(tracks)
    unseen = tracks.unmeasured(step.now)
    grow(records, unseen, dt)
    records['visible'], records['hidden'] = predict_existence(
        records['visible'], records['hidden'], dt, config.max_time_since_update, learned.calm
    )
    return _expect(tracks, unseen, measurements, learned, config, step)


def predict_with_camera(
    tracks: TrackTable[Bank],
    measurements: Measurements,
    learned: Adaptation,
    config: TrackerConfig,
    step: Step,
) -> Prediction | None:
    """Predict again if most objects have turned at once because the camera has moved.

    :param tracks: as predicted with a camera that stands.
    :return: None if the camera stands, or has been followed already.
    """
    if config.ego_motion != 'auto' or learned.camera.is_watched or len(tracks) < FEWEST:
        return None
    _follow_camera(tracks, measurements, learned, step, config)
    if learned.camera.stands:
        return None
    learned.camera.carry(tracks)
    return _expect(tracks, tracks.unmeasured(step.now), measurements, learned, config, step)


def _expect(
    tracks: TrackTable[Bank], unseen: Floats, measurements: Measurements, learned: Adaptation,
    config: TrackerConfig, step: Step,
) -> Prediction:  # fmt: skip
    """Collect the predictions of the filters and of what has been learned of the scene."""
    bank, records = tracks.filters, tracks.records
    mean, cov = bank.estimate()
    unmeasured, size = unseen, total(records['extent'])
    known = np.count_nonzero(measurements.size)
    sized = config.use_boxes if known or np.count_nonzero(size) else False
    if not sized:
        unmeasured = np.minimum(unmeasured, (step.now - records['shared']) / NANOSECONDS)
    elif known < measurements.size.size and len(records):
        lend_sizes(measurements, mean[:, :2], records)
    detected = learned.detection_rate.estimate(config.detection_probability)
    seen, chance = detected * records['visible'], maneuver_chance(records['rate'], unmeasured)
    return Prediction(
        step=step,
        bank=bank,
        records=records,
        center=mean[:, :2],
        velocity=mean[:, 2:4],
        variance=cov.diagonal(axis1=1, axis2=2)[:, :2].copy(),
        size=size,
        unseen=unseen,
        unmeasured=unmeasured,
        maneuvered=chance if config.maneuvers else np.zeros(len(records)),
        detection_probability=detected,
        log_odds=np.log(seen / (1.0 - seen)),
        noise=config.process_noise or learned.noise,
        speed=assumed_speed(learned, config),
        sudden_speed=learned.sudden_speed,
        log_density=math.log(config.clutter_density or learned.density),
        sized=sized,
        sizes=learned.sizes,
        finds_whole=learned.finds_whole,
        weak_below=learned.overlaps.weak_below,
    )


def coast(
    tracks: TrackTable[Bank], dt: float, learned: Adaptation, config: TrackerConfig
) -> TrackTable[Bank]:
    """Return a copy of all tracks, predicted by dt [s]; those that were measured coast."""
    copy = tracks.take(np.arange(len(tracks)))
    variance = process_variance(copy.records, learned, config)
    copy.filters.predict(dt, variance, known_acceleration(copy.records, config))
    copy.records['state'][copy.records['state'] == CONFIRMED] = COASTING
    return copy


def known_acceleration(records: Records, config: TrackerConfig) -> Floats | None:
    """Acceleration by second differences, (N, 2) [px/s^2]; None to use that of the model."""
    return np.asarray(records['acceleration']) if config.acceleration_span else None


def process_variance(records: Records, learned: Adaptation, config: TrackerConfig) -> Floats:
    """sigma_s^2 of tracks, equal on both axes, (N, 1) [px^2/s^4]."""
    if config.process_noise:
        return np.full((len(records), 1), config.process_noise**2)
    noise: Floats = learned.noise**2 * np.exp(2.0 * records['log_noise'])[:, None]
    return noise


def assumed_speed(learned: Adaptation, config: TrackerConfig) -> Floats:
    """Standard deviation of a new velocity on each axis, (2,) [px/s]."""
    return np.full(2, config.initial_speed) if config.initial_speed else learned.speed


def _follow_camera(
    tracks: TrackTable[Bank],
    measurements: Measurements,
    learned: Adaptation,
    step: Step,
    config: TrackerConfig,
) -> None:
    """Estimate the motion common to the tracks that were measured in the last frame."""
    if config.ego_motion not in ('auto', 'detections') or step.dt <= 0:
        return
    fresh = tracks.unmeasured(step.now) < LAST_FRAME * step.dt
    mean, cov = tracks.filters.estimate()
    variance = np.minimum(cov.diagonal(axis1=1, axis2=2)[fresh, :2], (LEAST_SPEED * step.dt) ** 2)
    if len(measurements):
        variance += median(measurements.variance)
    always = config.ego_motion == 'detections' or learned.camera.is_watched
    find = find_ego_motion if always else find_jump
    learned.camera.follow(mean[fresh, :2], variance, measurements.z, step.dt, find)
