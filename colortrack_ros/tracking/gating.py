"""Gating: the candidate blobs of each track."""

import math

import numpy as np

from colortrack_ros.data import Indices
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.rectangles import points_inside
from colortrack_ros.tracking.several_detectors import may_take

LOG_PI = math.log(math.pi)

UNBOUNDED = 1e9
"""Half width of the gate if gating is off: far beyond any picture [px]."""

NEAREST_IN_CROWD = 20
"""Mean number of candidates of a track above which only the nearest are compared. Objects that can
be told apart have a few; 3000 detections on one point would make nine million pairs. Assumed."""


def gate(
    prediction: Prediction, blobs: Measurements, config: TrackerConfig
) -> tuple[Indices, Indices]:
    """All pairs of a track and a blob whose score may be positive.

    The score is ln p / (1 - p) + ln N(e; 0, S) - ln density; it is positive if d^2 is below a bound
    set by S. The gate is a rectangle that covers the cases with and without a maneuver. Without
    gating every pair is a candidate; in a crowd the NEAREST_IN_CROWD nearest of each track are.
    Excluded are tracks already measured at this stamp, tentative tracks for what lies on one that
    is, and pairs of two colors if color gates.

    :return: (K,) tracks, ascending, and (K,) blobs.
    """
    variance = blobs.variance
    widest = np.maximum.reduce(variance, axis=None, initial=0.0)
    widest *= 1 + np.maximum.reduce(prediction.records['own_factor'], initial=0.0)
    narrowest = np.minimum.reduce(variance, axis=None, initial=1e9) + 1e-9
    T = prediction.unmeasured[:, None]
    way = prediction.velocity * (T / 2.0)
    turned = prediction.variance + (way**2 + (prediction.turn * T) ** 2) / 3.0
    S = prediction.variance + narrowest
    bound = 2.0 * (prediction.log_odds - (prediction.log_density + LOG_PI))
    bound -= np.log(S[:, 0] * S[:, 1])
    if prediction.sized:
        bound += 2.0 * prediction.best_fit
    half = np.sqrt(np.maximum(bound, 0.0)[:, None] * (turned + widest)) + np.abs(way)
    if prediction.sized:
        half += prediction.size / 2.0
    if not config.gating:
        half[:] = UNBOUNDED
    track, blob = points_inside(prediction.center, half, blobs.z, NEAREST_IN_CROWD * config.gating)
    if config.color_gating:
        same = prediction.records['color'][track] == blobs.rows['color'][blob]
        if np.count_nonzero(same) < len(same):
            track, blob = track[same], blob[same]
    if prediction.step.again:
        still = may_take(prediction, blobs, track, blob)
        track, blob = track[still], blob[still]
    return track, blob
