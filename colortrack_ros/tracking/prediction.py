"""What is expected of each track in a frame, before its detections are seen."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.estimation.bank import Bank
from colortrack_ros.tracking.blobs import centers
from colortrack_ros.tracking.blobs import measure
from colortrack_ros.tracking.blobs import sides_of_one
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.gating import candidates
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.measurements import Blobs
from colortrack_ros.tracking.merged import sides_of_several

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

FAR = 1e9
"""Half width of a gate that is none [px]."""


@dataclass(frozen=True)
class Prediction:
    """N tracks, predicted.

    :param bank: their filters.
    :param records: (N,) of dtype RECORD.
    :param center: (N, 2) predicted positions [px].
    :param velocity: (N, 2) [px/s].
    :param variance: (N, 2) of the positions [px^2].
    :param unmeasured: (N,) time since each was measured [s].
    :param chance: (N,) probability that it has maneuvered in that time.
    :param odds: (N,) log of the odds that it is detected in this frame.
    :param noise: standard deviation of the acceleration on each axis [px/s^2].
    :param speed: standard deviation of a new velocity on each axis [px/s].
    :param density: log of the density of detections that belong to no track [1/px^2].
    :param sized: there are tracks or blobs that have a size.
    """

    bank: Bank
    records: NDArray[np.void]
    center: Floats
    velocity: Floats
    variance: Floats
    unmeasured: Floats
    chance: Floats
    odds: Floats
    noise: float
    speed: float
    density: float
    sized: bool

    def candidates(self, blobs: Blobs, config: TrackerConfig) -> tuple[Indices, Indices]:
        """All pairs whose gain may be positive.

        With the gain ln p / (1 - p) + ln N(e; 0, S) - ln density that is d^2 below a bound that S
        sets. The gate is a rectangle that holds the gates of going on and of having maneuvered.
        Without a gate every pair is a candidate. None is with a track that has been measured at
        this stamp before, nor of two colors if color gates.

        :return: (K,) tracks, ascending, and (K,) blobs.
        """
        variance = blobs.R[:, [0, 1], [0, 1]]
        widest, narrowest = variance.max(initial=0.0), variance.min(initial=1e9) + 1e-9
        T = self.unmeasured[:, None] / 2
        way = self.velocity * T
        turned = self.variance + (way**2 + (2 * self.speed * T) ** 2) / 3
        S = self.variance + narrowest
        bound = 2 * (self.odds - self.density - math.log(np.pi)) - np.log(S[:, 0] * S[:, 1])
        half = np.sqrt(np.maximum(bound, 0.0)[:, None] * (turned + widest)) + np.abs(way)
        if self.sized:
            half += self.records['extent'].sum(axis=1) / 2
        if not config.gating:
            half[:] = FAR
        track, blob = candidates(self.center, half, blobs.z)
        fit = self.unmeasured[track] > 0
        if config.color_gating:
            fit &= self.records['color'][track] == blobs.rows['color'][blob]
        return (track, blob) if fit.all() else (track[fit], blob[fit])

    def pair(
        self, blobs: Blobs, track: Indices, blob: Indices, shared: NDArray[np.bool_] | None = None
    ) -> Hypotheses:
        """Compare blobs with tracks.

        :param track: (K,).
        :param blob: (K,).
        :param shared: (K,) pairs whose blob is shared by several tracks.
        """
        z, R = blobs.z[blob], blobs.R[blob]
        if self.sized:
            extent = self.records['extent'][track]
            expected, variance = self.center[track], self.variance[track]
            center = centers(z, blobs.box[blob], extent)
            weight = sides_of_one(center, expected, variance)
            if shared is not None and shared.any():
                one = np.flatnonzero(shared)
                weight[:, one] = sides_of_several(
                    blobs, blob[one], center[:, one], expected[one], variance[one]
                )
            z, R = measure(blobs, blob, extent, self.records['partial'][track], weight)
        compared = self.bank.compare(
            track, z, R, self.chance[track], self.unmeasured[track], self.speed
        )
        return Hypotheses(track, blob, z, R, compared)
