"""Repeats: pictures that a film shows twice, and a camera in the dark more often.

Films that were converted to a higher rate, and webcams with long exposures, show some pictures
again, at a later stamp, although the objects have moved on. Taken for measurements, they stop every
object, and in the next picture it jumps.
"""

import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.clock import Clock

STILL = 0.25
"""Largest motion of any object in a picture that is repeated [px]: once more compressed, it is not
the same to the bit. Centroids of balls moved by 0.22 px at most in four formats."""

LEAST_JUMP = 2.0
"""Motion in the next picture that shows that the one before was repeated [px]: what stands, or
creeps, gives the same detections, too. Eight times as much."""

MOST_REPEATS = 3
"""Repetitions on end: 15 pictures a second in a film of 60. What is repeated longer stands."""

TELLING_SECONDS = 1.0
"""Time in which there were two before, so that another is believed: one alone may be an object that
stopped, or turned round. A film of 25 pictures a second, shown at 30, has five."""

MOST_COMPARED = 50
"""Detections that are compared, to bound the time. Assumed."""


class Repeats:
    """Learns whether detections that are repeated are those of repeated pictures."""

    def __init__(self) -> None:
        self._last = np.zeros(0, DETECTION)
        self._sum, self._run = 0.0, 0
        self._told = -math.inf, -math.inf

    @np.errstate(over='ignore', invalid='ignore')  # nobody has looked at these rows yet
    def see(self, detections: Detections, clock: Clock, max_dt: float) -> bool:
        """Return whether a picture repeats one before, so that its detections tell nothing.

        :param clock: of the last picture that told something.
        :param max_dt: longest time to go without [s].
        :raises ValueError: these are no detections.
        """
        try:
            rows, last, self._last = detections.rows, self._last, detections.rows
            before, self._sum = self._sum, rows['u'].sum()
            (count,) = rows.shape
        except (AttributeError, IndexError, TypeError, ValueError):
            require_detections(detections)
            raise
        if rows.dtype is not DETECTION:
            require_detections(detections)
        if not self._run and abs(self._sum - before) > STILL * count:
            return False  # as nearly always
        alike = 0 < count == len(last)
        if not self._run and alike and not _moved(rows[:1], last) <= STILL:
            return False  # as among many, whose sum stays
        moved = _moved(rows, last) if alike else math.inf
        passed = (detections.stamp - clock.now) / NANOSECONDS
        if not moved <= STILL:  # nor is it a number, if theirs are not
            if 0 < self._run <= MOST_REPEATS and LEAST_JUMP <= moved < math.inf:
                self._told = self._told[1], detections.stamp
            self._run = 0
            return False
        if not 0 < passed <= max_dt:
            return False
        self._run += 1
        if self._run > MOST_REPEATS:
            self._told = -math.inf, -math.inf
        return detections.stamp - self._told[0] <= TELLING_SECONDS * NANOSECONDS


def require_detections(detections: Detections) -> None:
    """Refuse what is no detections, such as an array, or rows with other fields.

    :raises ValueError: it is not.
    """
    if not isinstance(detections, Detections):
        raise ValueError(
            f'expected Detections, got {type(detections).__name__}; of boxes it is '
            'Detections.from_boxes(boxes, stamp=nanoseconds), of points from_points'
        )
    rows = detections.rows
    named = isinstance(rows, np.ndarray) and rows.dtype.names == DETECTION.names
    if not named or rows.ndim != 1:
        raise ValueError(
            f'rows: expected an array (N,) of dtype DETECTION, got {type(rows).__name__} of shape '
            f'{np.shape(rows)}; make them by Detections.from_boxes or from_points'
        )


def _moved(rows: NDArray[np.void], last: NDArray[np.void]) -> float:
    """Return the largest distance from some rows to the nearest ones before [px]."""
    du, dv = (rows[name][:MOST_COMPARED, None] - last[name] for name in ('u', 'v'))
    return float(np.hypot(du, dv).min(axis=1).max())
