"""Rates of maneuvers, and process noise while coasting, learned from glances back.

Every third of a second, each track is compared with where it would be had it coasted since the last
glance. A single frame hardly tells a maneuver from noise, a third of a second does; and a lasting
acceleration, such as gravity, disturbs a filter that is updated in every frame little, but a
coasting one a lot.

Where frames are farther apart than a glance takes, each frame is a glance, and whatever lasts a
number of glances lasts longer in proportion.
"""

import math

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.estimation.gaussian import log_density
from colortrack_ros.estimation.motion.constant_velocity import REFERENCE_PERIOD
from colortrack_ros.estimation.records import Records

WINDOW = 1 / 3
"""Time between glances [s]: about the duration of an occlusion. Assumed."""

LONGEST = 1.0
"""Glances back over a longer time are skipped [s]. Assumed: three times WINDOW."""

FORMED_RATE, FORMED_TIME = 6, 0.4
"""Hits, and time [s], after which a track can coast by its velocity, and something is known of the
noise of its detections. Assumed. Hits alone would give the same motion another rate of maneuvers at
another rate of frames: with 12, coasting for a second a sigma of 0.93 at 200 Hz and 1.15 at 15 Hz
of that at 30 Hz."""

FIRST_RATE, FIRST_TIME = 0.5, 1.0
"""Prior rate of maneuvers of an object [1/s], and its weight as a time of observation [s]. Assumed:
one maneuver in two seconds."""

FORGETTING = 5.0
"""Time of observation after which the prior counts 1/e [s]. Assumed."""

CROWD_TIME = 2.0
"""Time of observation after which a track counts as much as the crowd [s]. Assumed."""

CROWD_GLANCES = 3.0
"""Glances after which a track counts as much as the crowd. Assumed."""

MANEUVER_MEMORY = 10.0
"""Time after which a glance counts 1/e [s]. Assumed."""

RATE_RANGE = (0.003, 20.0)
"""Bounds of the rates [1/s], so wide that they only keep the learning finite."""

MANEUVER_FIELDS = [
    ('anchor', 'f8', 4),
    ('anchor_cov', 'f8', 3),
    ('anchored', 'i8'),
    ('turns', 'f8'),
    ('watched', 'f8'),
    ('strayed', 'f8', 2),
    ('glances', 'f8'),
    ('blur', 'f8'),
    ('rate', 'f8'),
    ('filtered', 'f8', 2),
    ('astray', 'f8', 2),
]
"""What is recorded of a track: where it was at its last glance, position [px], velocity [px/s],
and variances of position, of both, and of velocity on an axis; stamp of that [ns]; expected
number of maneuvers and the time in which they were [s]; sum and number of estimates of the
density of its acceleration over a glance [px^2/s^3] on each axis; sum of their variances if there
is no acceleration; what follows from these: maneuvers [1/s], the density that its filter takes,
and what a coasting track needs beyond that [px^2/s^3]."""


MOST_MANEUVERS = 30.0
"""Mean number of maneuvers after which one is as good as certain: without any there is a chance of
1e-13 left, whose logarithm is finite."""


def maneuver_chance(rate: Floats, T: Floats) -> Floats:
    """Probability of a maneuver, (K,), within T [s] at a rate [1/s]: they are a Poisson process."""
    return -np.expm1(-np.minimum(rate * T, MOST_MANEUVERS))


class Maneuvers:
    """Learns rates of maneuvers and process noise while coasting, of the crowd and of each track.

    :ivar rate: of the crowd [1/s].
    :ivar stretch: time between frames over WINDOW, at least 1.
    """

    def __init__(self) -> None:
        self.rate, self.stretch = FIRST_RATE, 1.0
        self._sums: dict[str, Floats] = {
            'turns': np.zeros(()), 'watched': np.zeros(()), 'strayed': np.zeros(2),
            'glances': np.zeros(()), 'blur': np.zeros(()),
        }  # fmt: skip
        self._last = 0
        self._concluded = False

    def is_due(self, now: int) -> bool:
        """Whether it is time for the next glance, at the stamp [ns]."""
        return (now - self._last) / NANOSECONDS >= WINDOW

    def learn(
        self,
        records: Records,
        track: Indices,
        z: Floats,
        variance: Floats,
        mean: Floats,
        cov: Floats,
        now: int,
        speed: Floats,
    ) -> None:
        """Glance back.

        :param records: (N,) of all tracks, with MANEUVER_FIELDS.
        :param track: (K,) which were measured.
        :param z: (K, 2) their measurements [px].
        :param variance: (K,) of these on each axis [px^2].
        :param mean, cov: (N, n) and (N, n, n) estimates of all tracks after these.
        :param now: stamp of the frame [ns].
        :param speed: (2,) standard deviation of a new velocity on each axis [px/s].
        """
        passed = (now - self._last) / NANOSECONDS
        self._last, self._concluded = now, False
        T = (now - records['anchored'][track]) / NANOSECONDS
        recent = T / self.stretch <= LONGEST
        old = np.flatnonzero(recent & (records['anchor_cov'][track, 0] > 0))
        if len(old):
            self._glance(records, track[old], z[old], variance[old], T[old], speed, passed)
        age = (now - records['born'][track]) / NANOSECONDS + 1e-6  # stamps may be cut off
        ready = track[(records['hits'][track] >= FORMED_RATE) & (age >= FORMED_TIME)]
        records['anchor'][ready] = mean[ready, :4]
        P = cov[ready]
        records['anchor_cov'][ready] = (
            np.stack(
                [P[:, 0, 0] + P[:, 1, 1], P[:, 0, 2] + P[:, 1, 3], P[:, 2, 2] + P[:, 3, 3]], axis=1
            )
            / 2
        )
        records['anchored'][ready] = now

    def _glance(
        self,
        records: Records,
        track: Indices,
        z: Floats,
        variance: Floats,
        T: Floats,
        speed: Floats,
        passed: float,
    ) -> None:
        """Compare measurements, (K, 2), with their tracks coasted for T."""
        anchor, cov = records['anchor'][track], records['anchor_cov'][track]
        e = z - anchor[:, :2] - anchor[:, 2:] * T[:, None]
        known = variance + cov[:, 0] + 2 * T * cov[:, 1] + T**2 * cov[:, 2]
        cube = T**3 / 3
        S = np.zeros((len(T), 2, 2))
        density = records['filtered'][track] + records['astray'][track]
        S[:, (0, 1), (0, 1)] = known[:, None] + density * cube[:, None]
        going_on = log_density(e, S)
        way = anchor[:, 2:] * (T / 2)[:, None]
        S = way[:, :, None] * way[:, None, :] / 3
        S[:, (0, 1), (0, 1)] += known[:, None] + (speed * T[:, None]) ** 2 / 3
        turning = log_density(e + way, S)
        chance = maneuver_chance(records['rate'][track], T)
        odds = np.exp((turning - going_on).clip(-50, 50)) * chance / (1 - chance)
        turned = odds / (1 + odds)
        kept = 1 - turned
        remembered = math.exp(-passed / (MANEUVER_MEMORY * self.stretch))
        strayed = (kept / cube)[:, None] * (e * e - known[:, None])
        for name, new in (
            ('turns', turned), ('watched', T), ('strayed', strayed),
            ('glances', kept), ('blur', kept * (known / cube) ** 2),
        ):  # fmt: skip
            records[name][track] = remembered * records[name][track] + new
            self._sums[name] = remembered * self._sums[name] + new.sum(axis=0)
        turns, watched = float(self._sums['turns']), float(self._sums['watched'])
        first = FIRST_TIME * self.stretch * math.exp(-watched / (FORGETTING * self.stretch))
        self.rate = (FIRST_RATE * first + turns) / (first + watched)

    def conclude(self, records: Records, filtered: Floats) -> None:
        """Derive the rates and densities of each track, if anything is new.

        :param records: (N,) of all tracks, with MANEUVER_FIELDS.
        :param filtered: (N, 1) sigma_s^2 of their filters [px^2/s^4].
        """
        if self._concluded and np.count_nonzero(records['rate']) == len(records):
            return
        self._concluded = True
        crowd = CROWD_TIME * self.stretch
        rate = (crowd * self.rate + records['turns']) / (crowd + records['watched'])
        records['rate'] = rate.clip(*RATE_RANGE)
        glances, strayed, blur = (self._sums[name] for name in ('glances', 'strayed', 'blur'))
        worth = CROWD_GLANCES / max(float(glances), CROWD_GLANCES)
        count = np.maximum(worth * glances + records['glances'], 1e-9)
        density = (worth * strayed + records['strayed']) / count[:, None]
        density -= (np.sqrt(worth**2 * blur + records['blur']) / count)[:, None]
        records['astray'] = np.maximum(density - REFERENCE_PERIOD * filtered, 0.0)
        records['filtered'] = REFERENCE_PERIOD * filtered
