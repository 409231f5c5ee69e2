"""The parameters of every tracker."""

from dataclasses import dataclass

from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter

MOST_SECONDS = 3600.0
"""Longest time that may be set [s]: an hour. Assumed."""


@dataclass(frozen=True)
class TimeLimits(Config):
    """How long a track lives without a measurement, and a tracker without a frame."""

    max_time_since_update: float = parameter(
        1.5,
        'A track that has not been measured for longer is deleted; by the tracker of detections '
        'after four frames at the earliest, where these take longer than 0.125 s.',
        unit='s',
        limits=(0.0, MOST_SECONDS),
    )
    max_dt: float = parameter(
        2.0,
        'The tracker restarts if the stamps jump by more than this; that of detections not before '
        'they jump by more than four frames, where these take longer than 0.125 s, nor at a second '
        'such jump on end, of up to 15 s and at most 2.5 times the first: its source is so slow.',
        unit='s',
        limits=(1e-3, MOST_SECONDS),
        audience=EXPERT,
    )
